// Documents of a derivation: text and JSON; LaTeX is in latex.cpp. See the header.
#include "tools/derive/sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/derive/formulas.hpp"

namespace geodesic::tools::derive {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kWidth = 96;

void append(std::string& text, const std::string& title, const std::vector<Formula>& formulas) {
  if (!title.empty()) text += fmt::format("\n{}\n", title);
  for (const Formula& formula : formulas) {
    text += fmt::format(
        "  {}\n", wrapped(fmt::format("{} = {}", formula.left, formula.right), kWidth, "      "));
  }
}

std::string heading(const ClosedForm& form, const Origin& origin) {
  std::string text = fmt::format(
      "{}: closed forms, from T = 1/2 v' M(q) v and V(q)\n\n"
      "tau = M(q) a + C(q, v) v + g(q), (C v)_i = sum over j, k of Γi,jk v_j v_k, g = dV/dq\n"
      "v = dq/dt, a = dv/dt. SI units, radians; torques in N·m, forces in N.\n"
      "Gravity ({:g}, {:g}, {:g}) m/s² in the world.{}\n\nCoordinates\n",
      origin.robot, origin.gravity.x(), origin.gravity.y(), origin.gravity.z(),
      origin.rotors ? " M counts the motors' rotors." : "");
  for (const Coordinate& q : form.symbols.coordinates) {
    text += fmt::format("  {:<4} {:<28} {:<11} {}\n", q.name, q.joint, q.kind,
                        q.rotation ? "rad" : "m");
  }
  return text;
}

std::set<int> used_letters(const ClosedForm& form) {
  std::set<int> used;
  const auto look = [&](const Polynomial& polynomial) {
    for (const Term& term : polynomial.terms()) {
      for (const auto& power : form.symbols.monomials.powers(term.key.monomial)) {
        used.insert(power.letter);
      }
    }
  };
  for (const auto& row : form.metric) std::for_each(row.begin(), row.end(), look);
  std::for_each(form.gravity.begin(), form.gravity.end(), look);
  return used;
}

}  // namespace

std::vector<Letter> constants(const ClosedForm& form) {
  std::vector<Letter> list;
  for (const int letter : used_letters(form)) {
    const Letter& used = form.symbols.letters[static_cast<std::size_t>(letter)];
    if (used.kind != Letter::Kind::kCoordinate) list.push_back(used);
  }
  std::stable_sort(list.begin(), list.end(), [](const Letter& a, const Letter& b) {
    return std::tie(a.body, a.kind, a.name) < std::tie(b.body, b.kind, b.name);
  });
  return list;
}

void use_textbook_letters(ClosedForm& form) {
  std::vector<std::vector<int>> of_body;
  for (const int letter : used_letters(form)) {
    const Letter& used = form.symbols.letters[static_cast<std::size_t>(letter)];
    if (used.kind != Letter::Kind::kInertia) continue;
    of_body.resize(std::max(of_body.size(), static_cast<std::size_t>(used.body) + 1));
    of_body[static_cast<std::size_t>(used.body)].push_back(letter);
  }
  for (const std::vector<int>& letters : of_body) {
    if (letters.size() != 1) continue;
    Letter& only = form.symbols.letters[static_cast<std::size_t>(letters.front())];
    if (only.name[1] != only.name[2]) continue;
    only.name = fmt::format("I{}", only.body);
    only.latex = fmt::format("I_{{{}}}", only.body);
  }
}

std::string text_document(ClosedForm& form, const Origin& origin, const Content& content,
                          int digits) {
  const Formulas formulas(form, Notation::kText, digits);
  std::string text = heading(form, origin);
  if (const std::vector<Letter> letters = constants(form); !letters.empty()) {
    text += "\nLetters\n";
    for (const Letter& letter : letters) {
      text += fmt::format("  {:<6} = {:<16} {:<6} {}\n", letter.name,
                          formulas.layout().number(letter.value), letter.unit, letter.meaning);
    }
  }
  if (!origin.notes.empty()) {
    text += "\nTaken as exact (--as-written leaves figures as they are)\n";
    for (const std::string& note : origin.notes) text += fmt::format("  {}\n", note);
  }
  if (content.metric) append(text, "Metric M(q)", formulas.metric());
  if (content.christoffel) {
    const Connection connection = distinct(form.christoffel);
    append(text,
           "Christoffel symbols of the first kind, Γi,jk = Γi,kj = "
           "1/2 (dMij/dqk + dMik/dqj - dMjk/dqi)",
           formulas.values(connection, "h"));
    if (connection.symbols.empty()) {
      text += "  all are 0: M is constant\n";
    } else {
      append(text, "", formulas.symbols(connection, "h", false));
      text += "  all others are 0\n";
    }
  }
  if (content.second_kind) {
    const Connection connection = distinct(form.second_kind);
    append(text,
           "Christoffel symbols of the second kind, Γ^i_jk = sum over l of (M^-1)il Γl,jk: the "
           "geodesics are a^i = -Γ^i_jk v^j v^k",
           {formulas.determinant()});
    append(text, "", formulas.values(connection, "n"));
    append(text, "", formulas.symbols(connection, "n", true));
    text += "  all others are 0\n";
  }
  if (content.gravity) append(text, "Gravity g(q)", formulas.gravity());
  if (content.equations) {
    append(text, "Equations of motion (Euler-Lagrange: d/dt dL/dv - dL/dq = tau, L = T - V)",
           formulas.equations(distinct(form.christoffel)));
  }
  return text;
}

ordered_json json_document(ClosedForm& form, const Origin& origin, const Content& content) {
  const Formulas formulas(form, Notation::kPlain, 17);
  const Layout& layout = formulas.layout();
  ordered_json answer{{"robot", origin.robot},
                      {"source", "geodesic " GEODESIC_VERSION},
                      {"gravity", {origin.gravity.x(), origin.gravity.y(), origin.gravity.z()}},
                      {"rotors", origin.rotors},
                      {"coordinates", ordered_json::array()},
                      {"symbols", ordered_json::object()}};
  for (const Coordinate& q : form.symbols.coordinates) {
    answer["coordinates"].push_back({{"name", q.name},
                                     {"joint", q.joint},
                                     {"kind", q.kind},
                                     {"unit", q.rotation ? "rad" : "m"}});
  }
  for (const Letter& letter : constants(form)) {
    answer["symbols"][letter.name] = {
        {"value", letter.value}, {"unit", letter.unit}, {"meaning", letter.meaning}};
  }
  answer["notes"] = origin.notes;
  answer["terms"] = count_terms(form);
  const auto write = [&](const std::vector<Polynomial>& list, Gather gather) {
    ordered_json row = ordered_json::array();
    for (const Polynomial& entry : list) row.push_back(layout.write(entry, gather));
    return row;
  };
  if (content.metric) {
    answer["M"] = ordered_json::array();
    for (const auto& row : form.metric) answer["M"].push_back(write(row, Gather::kMass));
  }
  const auto connection = [&](const auto& symbols) {
    ordered_json cube = ordered_json::array();
    for (const auto& matrix : symbols) {
      ordered_json slice = ordered_json::array();
      for (const auto& row : matrix) slice.push_back(write(row, Gather::kWave));
      cube.push_back(slice);
    }
    return cube;
  };
  if (content.christoffel) answer["christoffel_first_kind"] = connection(form.christoffel);
  if (content.second_kind) {
    answer["determinant"] = layout.write(form.determinant, Gather::kMass);
    answer["christoffel_second_kind_times_determinant"] = connection(form.second_kind);
  }
  if (content.gravity) answer["g"] = write(form.gravity, Gather::kWave);
  if (content.equations) {
    const Connection symbols = distinct(form.christoffel);
    answer["h"] = ordered_json::object();
    for (const Formula& value : formulas.values(symbols, "h"))
      answer["h"][value.left] = value.right;
    answer["equations"] = ordered_json::array();
    for (const Formula& equation : formulas.equations(symbols)) {
      answer["equations"].push_back(fmt::format("{} = {}", equation.left, equation.right));
    }
  }
  return answer;
}

}  // namespace geodesic::tools::derive
