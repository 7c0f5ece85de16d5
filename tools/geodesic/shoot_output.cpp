// Implements shoot_output.hpp but for the picture (shoot_plot.cpp).
#include "tools/geodesic/shoot_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

ordered_json list(const Eigen::VectorXd& x) {
  return ordered_json(std::vector<double>(x.begin(), x.end()));
}

ordered_json columns(const std::vector<Sample>& samples) {
  ordered_json time = ordered_json::array();
  ordered_json q = time;
  ordered_json v = time;
  ordered_json kinetic = time;
  ordered_json energy = time;
  ordered_json momentum = time;
  ordered_json place = time;
  for (const Sample& sample : samples) {
    time.push_back(sample.time_s);
    q.push_back(list(sample.q));
    v.push_back(list(sample.v));
    kinetic.push_back(sample.kinetic_j);
    energy.push_back(sample.energy_j);
    momentum.push_back(list(sample.momentum));
    place.push_back(list(sample.place));
  }
  return {{"time", time},     {"q", q},
          {"v", v},           {"kinetic_energy", kinetic},
          {"energy", energy}, {"momentum", momentum},
          {"position", place}};
}

const char* to_string(control::GeodesicOutcome outcome) {
  switch (outcome) {
    case control::GeodesicOutcome::kFound:
      return "found";
    case control::GeodesicOutcome::kConjugate:
      return "conjugate";
    case control::GeodesicOutcome::kNotFound:
      return "not found";
    case control::GeodesicOutcome::kSingularMetric:
      break;
  }
  return "singular metric";
}

ordered_json to_json(const control::Action& action) {
  return {{"action", action.action},
          {"length", action.length},
          {"lowest_kinetic_energy", action.lowest_energy},
          {"highest_kinetic_energy", action.highest_energy}};
}

void print_numbers(const char* name, const Eigen::VectorXd& values, const char* unit) {
  fmt::print("{:<8}", name);
  for (const double value : values) fmt::print(" {:>11.6g}", value);
  fmt::print("  {}\n", unit);
}

void print_between(const Comparison& between) {
  const auto row = [](const char* name, const control::Action& a) {
    fmt::print("{:<14}{:>14.8g}{:>18.8g}{:>16.6g}{:>16.6g}\n", name, a.action, a.length,
               a.lowest_energy, a.highest_energy);
  };
  fmt::print("\nfound in {} round{} of Newton's iteration; the end is missed by {:.1e}\n\n",
             between.found.shots, between.found.shots == 1 ? "" : "s", between.found.miss);
  fmt::print("{:<14}{:>14}{:>18}{:>16}{:>16}\n", "", "action [J·s]", "length [√kg·m]",
             "lowest T [J]", "highest T [J]");
  row("geodesic", between.geodesic);
  row("straight line", between.straight);
  const double share = between.straight.action > 0.0
                           ? 100.0 * (between.geodesic.action / between.straight.action - 1.0)
                           : 0.0;
  fmt::print("the geodesic's action is {:+.3g} % of the straight line's{}\n", share,
             share > 0.0 ? ": it is not the shortest way" : "");
  if (between.found.conjugate_s) {
    fmt::print(
        "conjugate point at {:.4g} s: from there on the action is stationary, not least; positive\n"
        "curvature has brought neighbouring geodesics together again, and a shorter way exists\n",
        *between.found.conjugate_s);
  } else {
    fmt::print("no conjugate point on the way: no neighbouring motion has less action\n");
  }
}

void print_conservation(const Shot& shot) {
  const Conservation& kept = shot.conservation;
  fmt::print(
      "\nenergy: {:.6g} J; changes by at most {:.1e} of it, drifts by {:+.1e} ± {:.1e} in all\n",
      shot.motion.samples.front().energy_j, kept.energy_band, kept.energy_drift,
      2.0 * kept.drift_noise);
  if (kept.linear) {
    fmt::print("momentum: linear kept to {:.1e}, angular to {:.1e} of its magnitude\n",
               *kept.linear, *kept.angular);
  }
}

}  // namespace

std::vector<std::string> coordinate_names(const control::Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const control::Factor& factor : mechanism.factors()) {
    if (factor.nq == 1) {
      names.push_back(factor.name);
      continue;
    }
    using Parts = std::vector<const char*>;
    const Parts parts = factor.nq == 3   ? Parts{"x", "y", "angle"}
                        : factor.nq == 4 ? Parts{"qx", "qy", "qz", "qw"}
                                         : Parts{"x", "y", "z", "qx", "qy", "qz", "qw"};
    for (const char* part : parts) names.push_back(fmt::format("{}.{}", factor.name, part));
  }
  return names;
}

ordered_json to_json(const control::Mechanism& mechanism, const Shot& shot) {
  const Conservation& kept = shot.conservation;
  ordered_json answer{{"robot", shot.robot},
                      {"source", "geodesic " GEODESIC_VERSION},
                      {"floating_base", mechanism.floating()},
                      {"nq", mechanism.nq()},
                      {"nv", mechanism.dof()},
                      {"coordinates", coordinate_names(mechanism)},
                      {"gravity", list(mechanism.gravity())},
                      {"ee_frame", shot.frame},
                      {"integrator", to_string(shot.options.integrator)},
                      {"duration", shot.options.duration_s},
                      {"steps", shot.options.steps},
                      {"ns_per_step", shot.motion.ns_per_step},
                      {"energy",
                       {{"start", shot.motion.samples.front().energy_j},
                        {"largest_change", kept.energy_band},
                        {"drift", kept.energy_drift},
                        {"drift_noise", kept.drift_noise}}}};
  if (kept.linear) answer["momentum"] = {{"linear", *kept.linear}, {"angular", *kept.angular}};
  if (shot.between) {
    const control::GeodesicBetween& found = shot.between->found;
    answer["between"] = {{"outcome", to_string(found.outcome)},
                         {"rounds", found.shots},
                         {"miss", found.miss},
                         {"start_velocity", list(found.start_velocity)},
                         {"conjugate_at", nullptr},
                         {"geodesic", to_json(shot.between->geodesic)},
                         {"straight", to_json(shot.between->straight)}};
    if (found.conjugate_s) answer["between"]["conjugate_at"] = *found.conjugate_s;
    answer["straight_line"] = columns(shot.between->line);
  }
  answer["trajectory"] = columns(shot.motion.samples);
  if (!shot.motion.opening.empty()) answer["opening"] = columns(shot.motion.opening);
  return answer;
}

void print(const control::Mechanism& mechanism, const Shot& shot) {
  const Sample& first = shot.motion.samples.front();
  const Sample& last = shot.motion.samples.back();
  fmt::print("robot {}: {} for {:.6g} s in {} steps ({} integrator, {:.2f} µs a step)\n\n",
             shot.robot,
             mechanism.gravity().isZero(0.0) ? "a geodesic of its kinetic energy"
                                             : "free motion under gravity",
             shot.options.duration_s, shot.options.steps, to_string(shot.options.integrator),
             1e-3 * shot.motion.ns_per_step);
  print_numbers("start q", first.q, "rad, m");
  print_numbers("start v", first.v, "rad/s, m/s");
  print_numbers("end q", last.q, "rad, m");
  print_numbers("end v", last.v, "rad/s, m/s");
  fmt::print("{} goes from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m\n", shot.frame,
             first.place.x(), first.place.y(), first.place.z(), last.place.x(), last.place.y(),
             last.place.z());
  if (shot.between) print_between(*shot.between);
  print_conservation(shot);
}

std::string to_csv(const control::Mechanism& mechanism, const Motion& motion) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "time");
  for (const std::string& name : coordinate_names(mechanism)) fmt::format_to(out, ",q {}", name);
  for (const control::Factor& factor : mechanism.factors()) {
    for (int k = 0; k < factor.nv; ++k) {
      if (factor.nv == 1) {
        fmt::format_to(out, ",v {}", factor.name);
      } else {
        fmt::format_to(out, ",v {}.{}", factor.name, k);
      }
    }
  }
  fmt::format_to(out, ",kinetic energy,energy");
  if (mechanism.floating()) fmt::format_to(out, ",px,py,pz,Lx,Ly,Lz");
  fmt::format_to(out, ",x,y,z\n");
  for (const Sample& sample : motion.samples) {
    fmt::format_to(out, "{}", sample.time_s);
    for (const double x : sample.q) fmt::format_to(out, ",{}", x);
    for (const double x : sample.v) fmt::format_to(out, ",{}", x);
    fmt::format_to(out, ",{},{}", sample.kinetic_j, sample.energy_j);
    if (mechanism.floating()) {
      for (const double x : sample.momentum) fmt::format_to(out, ",{}", x);
    }
    for (const double x : sample.place) fmt::format_to(out, ",{}", x);
    fmt::format_to(out, "\n");
  }
  return fmt::to_string(text);
}

}  // namespace geodesic::tools
