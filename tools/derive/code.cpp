// Writes functions; see the header.
#include "tools/derive/code.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "tools/derive/formulas.hpp"
#include "tools/derive/products.hpp"
#include "tools/derive/shared_graph.hpp"

namespace geodesic::tools::derive {
namespace {

constexpr std::size_t kWidth = 98;

struct Language {
  std::string comment;       ///< begins a comment
  std::string declaration;   ///< before a local value
  std::string continuation;  ///< at the end of a line that goes on
  int first_index = 0;
  char open = '[';
  char close = ']';
};

const Language kC{"//", "const double ", "", 0, '[', ']'};
const Language kMatlab{"%", "", " ...", 1, '(', ')'};

// One function's body: sines and cosines, shared parts, results.
class Body {
 public:
  Body(const ClosedForm& form, const Language& language) : form_(form), language_(language) {}

  Node polynomial(const Polynomial& polynomial) {
    std::vector<FlatTerm> terms;
    for (const ProductTerm& product : shortest_form(polynomial)) {
      FlatTerm term{product.value, {}};
      for (const auto& power : form_.symbols.monomials.powers(product.monomial)) {
        const Letter& letter = form_.symbols.letters[static_cast<std::size_t>(power.letter)];
        const Node leaf = graph_.leaf(letter.dof >= 0 ? element("q", letter.dof) : letter.name);
        term.leaves.insert(term.leaves.end(), static_cast<std::size_t>(power.exponent), leaf);
      }
      for (const TrigPower& factor : product.factors) {
        term.leaves.insert(term.leaves.end(), static_cast<std::size_t>(factor.exponent),
                           wave(factor));
      }
      std::sort(term.leaves.begin(), term.leaves.end());
      terms.push_back(std::move(term));
    }
    return graph_.nested(std::move(terms));
  }

  std::string element(const std::string& vector, int index) const {
    return fmt::format("{}{}{}{}", vector, language_.open, index + language_.first_index,
                       language_.close);
  }

  SharedGraph& graph() { return graph_; }

  void output(const std::string& left, Node node) { outputs_.emplace_back(left, node); }

  std::string text() {
    std::vector<Node> roots;
    for (const auto& [left, node] : outputs_) roots.push_back(node);
    const std::vector<int> uses = graph_.uses(roots);
    names_.assign(static_cast<std::size_t>(graph_.size()), "");
    std::string text;
    for (const auto& [factor, name] : waves_) {
      text += line(fmt::format("{}{} = {}({})", language_.declaration, name,
                               factor.sine ? "sin" : "cos", argument(factor.wave)));
    }
    int temporaries = 0;
    for (Node node = 0; node < graph_.size(); ++node) {
      const auto at = static_cast<std::size_t>(node);
      if (uses[at] < 2 || graph_[node].parts.empty()) continue;
      const std::string value = expression(node);
      names_[at] = fmt::format("t{}", ++temporaries);
      text += line(fmt::format("{}{} = {}", language_.declaration, names_[at], value));
    }
    for (const auto& [left, node] : outputs_) {
      text += line(fmt::format("{} = {}", left, operand(node, false)));
    }
    return text;
  }

  // A statement, broken before signs.
  std::string line(const std::string& statement) const {
    std::string result = "  ";
    std::size_t begin = 0;
    std::size_t possible = 0;
    for (std::size_t i = 1; i + 2 < statement.size(); ++i) {
      const bool sign = statement[i + 1] == '+' || statement[i + 1] == '-';
      if (statement[i] != ' ' || !sign || statement[i + 2] != ' ') continue;
      if (i - begin > kWidth - 8 && possible > begin) {
        result += statement.substr(begin, possible - begin);
        result += language_.continuation;
        result += "\n      ";
        begin = possible + 1;
      }
      possible = i;
    }
    return result + statement.substr(begin) + ";\n";
  }

 private:
  Node wave(const TrigPower& factor) {
    const TrigPower once{factor.wave, factor.sine, 1};
    const auto [place, fresh] = waves_.try_emplace(once, "");
    if (fresh) place->second = fmt::format("w{}", waves_.size());
    return graph_.leaf(place->second);
  }

  std::string argument(const Wave& wave) const {
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < form_.symbols.angles.size(); ++i) {
      if (wave[i] == 0) continue;
      const Angle& angle = form_.symbols.angles[i];
      const double factor = wave[i] * angle.ratio;
      std::string part = factor < 0.0 ? "-" : "";
      if (std::abs(factor) != 1.0) part += fmt::format("{}*", std::abs(factor));
      parts.push_back(part + element("q", angle.dof));
    }
    return signed_sum(parts);
  }

  std::string operand(Node node, bool in_product) const {
    const auto at = static_cast<std::size_t>(node);
    if (!names_[at].empty()) return names_[at];
    const bool bracket = in_product && graph_[node].kind == SharedGraph::Content::Kind::kSum;
    return bracket ? fmt::format("({})", expression(node)) : expression(node);
  }

  std::string expression(Node node) const {
    const SharedGraph::Content& content = graph_[node];
    switch (content.kind) {
      case SharedGraph::Content::Kind::kNumber:
        return fmt::format("{}", content.value);
      case SharedGraph::Content::Kind::kLeaf:
        return content.text;
      case SharedGraph::Content::Kind::kSum: {
        std::vector<std::string> parts;
        for (const Node part : content.parts) parts.push_back(operand(part, false));
        return signed_sum(parts);
      }
      case SharedGraph::Content::Kind::kProduct:
        break;
    }
    std::vector<std::string> factors;
    std::string sign;
    for (const Node part : content.parts) {
      if (graph_[part].kind == SharedGraph::Content::Kind::kNumber && graph_[part].value == -1.0) {
        sign = "-";
      } else {
        factors.push_back(operand(part, true));
      }
    }
    return fmt::format("{}{}", sign, fmt::join(factors, "*"));
  }

  const ClosedForm& form_;
  const Language& language_;
  SharedGraph graph_;
  std::map<TrigPower, std::string> waves_;
  std::vector<std::pair<std::string, Node>> outputs_;
  std::vector<std::string> names_;
};

// tau_i = sum of Gamma_i,jk v_j v_k + g_i.
std::string forces(const ClosedForm& form, const Language& language) {
  Body body(form, language);
  SharedGraph& graph = body.graph();
  const Connection connection = distinct(form.christoffel);
  std::vector<Node> values;
  values.reserve(connection.values.size());
  for (const Polynomial& value : connection.values) values.push_back(body.polynomial(value));
  for (int i = 0; i < form.n; ++i) {
    std::vector<Node> sum;
    std::map<int, std::vector<FlatTerm>> rates;
    for (const SymbolOfConnection& symbol : connection.symbols) {
      if (symbol.i != i) continue;
      rates[symbol.value].push_back(
          {symbol.sign * (symbol.j == symbol.k ? 1.0 : 2.0),
           {graph.leaf(body.element("v", symbol.j)), graph.leaf(body.element("v", symbol.k))}});
    }
    sum.reserve(rates.size() + 1);
    for (auto& [value, terms] : rates) {
      sum.push_back(
          graph.product({values[static_cast<std::size_t>(value)], graph.nested(std::move(terms))}));
    }
    sum.push_back(body.polynomial(form.gravity[static_cast<std::size_t>(i)]));
    body.output(body.element("tau", i), graph.sum(sum));
  }
  return body.text();
}

std::string metric(const ClosedForm& form, const Language& language) {
  Body body(form, language);
  const bool flat = language.first_index == 0;
  const auto entry = [&](int i, int j) {
    return flat ? fmt::format("M[{}]", i * form.n + j) : fmt::format("M({},{})", i + 1, j + 1);
  };
  std::string mirrored;
  for (int i = 0; i < form.n; ++i) {
    for (int j = i; j < form.n; ++j) {
      body.output(
          entry(i, j),
          body.polynomial(form.metric[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]));
      if (i != j) mirrored += body.line(fmt::format("{} = {}", entry(j, i), entry(i, j)));
    }
  }
  return body.text() + mirrored;
}

std::string heading(const ClosedForm& form, const Origin& origin, const Language& language,
                    const std::string& what) {
  const std::string& c = language.comment;
  std::string text = fmt::format(
      "{} {} of {}, by geodesic {}. SI units, radians; gravity ({:g}, {:g}, {:g}) m/s².\n{} "
      "tau = M(q) a + C(q, v) v + g(q); v = dq/dt, a = dv/dt.{}\n",
      c, what, origin.robot, GEODESIC_VERSION, origin.gravity.x(), origin.gravity.y(),
      origin.gravity.z(), c, origin.rotors ? " M counts the motors' rotors." : "");
  int index = language.first_index;
  for (const Coordinate& q : form.symbols.coordinates) {
    text += fmt::format("{}   q{}{}{}  {}, {} [{}]\n", c, language.open, index++, language.close,
                        q.joint, q.kind, q.rotation ? "rad" : "m");
  }
  for (const std::string& note : origin.notes) text += fmt::format("{} {}\n", c, note);
  return text;
}

std::string letters(const ClosedForm& form, const Language& language,
                    const std::string& declaration, const std::string& indent) {
  std::string text;
  for (const Letter& letter : constants(form)) {
    text += fmt::format("{}{}{} = {};  {} {}: {}\n", indent, declaration, letter.name, letter.value,
                        language.comment, letter.unit, letter.meaning);
  }
  return text;
}

// The robot's name as one of a file.
std::string file_name(const std::string& robot) {
  std::string name;
  for (const char c : robot) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    name += plain ? c : '_';
  }
  return name.empty() ? "robot" : name;
}

}  // namespace

CodeFile c_code(const ClosedForm& form, const Origin& origin) {
  const int n = form.n;
  std::string text = heading(form, origin, kC, "Metric, and Coriolis and gravity forces");
  text += fmt::format("#include <math.h>\n\n{}", letters(form, kC, "static const double ", ""));
  text += fmt::format(
      "\n// M(q), row by row [kg·m², kg·m, kg].\n"
      "void M_metric(const double q[{}], double M[{}]) {{\n  (void)q;\n{}}}\n",
      n, n * n, metric(form, kC));
  text += fmt::format(
      "\n// C(q, v) v + g(q) [N·m, N].\n"
      "void Cgrav_forces(const double q[{0}], const double v[{0}], double tau[{0}]) {{\n"
      "  (void)q;\n  (void)v;\n{1}}}\n",
      n, forces(form, kC));
  return {fmt::format("{}_closed_form.c", file_name(origin.robot)), text};
}

std::vector<CodeFile> matlab_code(const ClosedForm& form, const Origin& origin) {
  const std::string values = letters(form, kMatlab, "", "  ");
  return {
      {"M_metric.m", fmt::format("function M = M_metric(q)\n{}{}  M = zeros({});\n{}end\n",
                                 heading(form, origin, kMatlab, "Metric M(q), [kg·m², kg·m, kg],"),
                                 values, form.n, metric(form, kMatlab))},
      {"Cgrav_forces.m",
       fmt::format("function tau = Cgrav_forces(q, v)\n{}{}  tau = zeros({}, 1);\n{}end\n",
                   heading(form, origin, kMatlab,
                           "Coriolis and gravity forces C(q, v) v + g(q), [N·m, N],"),
                   values, form.n, forces(form, kMatlab))}};
}

}  // namespace geodesic::tools::derive
