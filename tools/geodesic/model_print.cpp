// Implements model_print.hpp.
#include "tools/geodesic/model_print.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "tools/geodesic/quantities.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

void print_numbers(const ordered_json& row) {
  for (const auto& value : row) {
    fmt::print(" {:>12}", value.is_null() ? "-" : fmt::format("{:.6g}", value.get<double>()));
  }
}

void print_rows(const ordered_json& rows) {
  for (const auto& row : rows) {
    fmt::print("    ");
    print_numbers(row);
    fmt::print("\n");
  }
}

void print_value(const ordered_json& value) {
  if (value.is_null()) {
    fmt::print("     none: singular\n");
  } else if (value.is_number()) {
    fmt::print("     {:>12.6g}\n", value.get<double>());
  } else if (value.empty() || !value[0].is_array()) {
    print_rows(ordered_json::array({value}));
  } else if (value[0].empty() || !value[0][0].is_array()) {
    print_rows(value);
  } else {
    for (std::size_t i = 0; i < value.size(); ++i) {
      fmt::print("   [{}]\n", i);
      print_rows(value[i]);
    }
  }
}

}  // namespace

void print_robot(const control::TreeDescription& tree, const control::Mechanism& mechanism) {
  fmt::print("robot {}: {} joint{}, {:.6g} kg that move\n\n", tree.name,
             mechanism.joint_names().size(), mechanism.joint_names().size() == 1 ? "" : "s",
             mechanism.moving_mass());
  fmt::print("{:<32}{:>10}   {:<32}\n", "link", "mass [kg]", "centre of mass [m]");
  for (const control::LinkDescription& link : tree.links) {
    if (link.inertia.mass_kg <= 0.0) continue;
    const Eigen::Vector3d& com = link.inertia.com_m;
    fmt::print("{:<32}{:>10.4f}   {:>9.4f} {:>9.4f} {:>9.4f}\n", link.name, link.inertia.mass_kg,
               com.x(), com.y(), com.z());
  }
  fmt::print("\njoints: {}\n", fmt::join(mechanism.joint_names(), ", "));
}

void print_state(const ordered_json& state, const std::vector<std::string>& what,
                 const std::string& frame) {
  for (const char* name : {"q", "v", "a"}) {
    fmt::print("{:<4}", name);
    print_numbers(state[name]);
    fmt::print("\n");
  }
  for (const std::string& name : what) {
    const std::string meaning = find_quantity(name).meaning;
    const bool of_link = name.starts_with("ee_") || name.ends_with("_ee");
    fmt::print("{}: {}{}\n", name, meaning, of_link ? fmt::format("; {}", frame) : "");
    print_value(state[name]);
  }
}

}  // namespace geodesic::tools
