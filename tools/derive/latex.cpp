// The LaTeX document of a derivation; see sheet.hpp.
#include <fmt/format.h>

#include <string>

#include "tools/derive/formulas.hpp"
#include "tools/derive/sheet.hpp"

namespace geodesic::tools::derive {
namespace {

constexpr std::size_t kWidth = 110;  // characters of source a line of a formula

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\') {
      result += "\\textbackslash{}";
      continue;
    }
    if (c == '^' || c == '~') {
      result += fmt::format("\\{}{{}}", c);
      continue;
    }
    if (std::string("#$%&_{}").find(c) != std::string::npos) result += '\\';
    result += c;
  }
  return result;
}

// "kg·m²" in math mode.
std::string unit(const std::string& text) {
  std::string result = escaped(text);
  const auto replace = [&](const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = result.find(from, at)) != std::string::npos; at += to.size()) {
      result.replace(at, from.size(), to);
    }
  };
  replace("·", "$\\cdot$");
  replace("²", "$^2$");
  return result;
}

std::string aligned(const std::vector<Formula>& formulas) {
  std::string text = "\\begin{align*}\n";
  for (std::size_t i = 0; i < formulas.size(); ++i) {
    const std::string& right = formulas[i].right;
    text += fmt::format("  {} &= {}{}\n", formulas[i].left, wrapped(right, kWidth, "\\\\ &\\quad "),
                        i + 1 < formulas.size() ? " \\\\" : "");
  }
  text += "\\end{align*}\n";
  return text;
}

void append(std::string& text, const std::string& title, const std::string& words,
            const std::vector<Formula>& formulas) {
  text += fmt::format("\n\\section*{{{}}}\n{}", title, words);
  text += formulas.empty() ? "All are $0$.\n" : aligned(formulas);
}

void append_tables(std::string& text, const ClosedForm& form, const Origin& origin,
                   const Layout& layout) {
  text += "\n\\begin{center}\n\\begin{tabular}{lll}\n";
  for (const Coordinate& q : form.symbols.coordinates) {
    text += fmt::format("  ${}$ & {}, {} & {} \\\\\n", q.latex, escaped(q.joint), q.kind,
                        q.rotation ? "rad" : "m");
  }
  text += "\\end{tabular}\n\\end{center}\n";
  if (const std::vector<Letter> letters = constants(form); !letters.empty()) {
    text += "\n\\begin{center}\n\\begin{tabular}{llll}\n";
    for (const Letter& letter : letters) {
      text += fmt::format("  ${}$ & ${}$ & {} & {} \\\\\n", letter.latex,
                          layout.number(letter.value), unit(letter.unit), escaped(letter.meaning));
    }
    text += "\\end{tabular}\n\\end{center}\n";
  }
  if (origin.notes.empty()) return;
  text += "\nTaken as exact:\n\\begin{itemize}\n";
  for (const std::string& note : origin.notes) {
    text += fmt::format("  \\item {}\n", unit(note));
  }
  text += "\\end{itemize}\n";
}

}  // namespace

std::string latex_document(ClosedForm& form, const Origin& origin, const Content& content,
                           int digits) {
  const Formulas formulas(form, Notation::kLatex, digits);
  std::string text = fmt::format(
      "% The closed forms of {}, by geodesic {}. Compile with LaTeX, or include what\n"
      "% stands between \\begin{{document}} and \\end{{document}}; needs amsmath.\n"
      "\\documentclass{{article}}\n\\usepackage[utf8]{{inputenc}}\n"
      "\\usepackage[margin=2cm]{{geometry}}\n\\usepackage{{amsmath}}\n"
      "\\allowdisplaybreaks\n\\begin{{document}}\n"
      "\\section*{{{}: closed forms}}\n"
      "From $T = \\frac{{1}}{{2}} \\dot q^{{T}} M(q) \\dot q$ and $V(q)$: "
      "$\\tau = M(q) \\ddot q + C(q, \\dot q) \\dot q + g(q)$. SI units, radians; gravity "
      "$({:g}, {:g}, {:g})$~m/s$^2$ in the world.{}\n",
      escaped(origin.robot), GEODESIC_VERSION, escaped(origin.robot), origin.gravity.x(),
      origin.gravity.y(), origin.gravity.z(),
      origin.rotors ? " $M$ counts the motors' rotors." : "");
  append_tables(text, form, origin, formulas.layout());
  if (content.metric) append(text, "Metric", "", formulas.metric());
  if (content.christoffel) {
    const Connection connection = distinct(form.christoffel);
    std::vector<Formula> list = formulas.values(connection, "h");
    const std::vector<Formula> symbols = formulas.symbols(connection, "h", false);
    list.insert(list.end(), symbols.begin(), symbols.end());
    append(text, "Christoffel symbols of the first kind",
           "$\\Gamma_{i,jk} = \\Gamma_{i,kj} = \\frac{1}{2} (\\partial M_{ij} / \\partial q_k + "
           "\\partial M_{ik} / \\partial q_j - \\partial M_{jk} / \\partial q_i)$; those not "
           "listed are $0$.\n",
           list);
  }
  if (content.second_kind) {
    const Connection connection = distinct(form.second_kind);
    std::vector<Formula> list{formulas.determinant()};
    for (const auto& more :
         {formulas.values(connection, "n"), formulas.symbols(connection, "n", true)}) {
      list.insert(list.end(), more.begin(), more.end());
    }
    append(text, "Christoffel symbols of the second kind",
           "$\\Gamma^i_{jk} = (M^{-1})^{il} \\Gamma_{l,jk}$; those not listed are $0$.\n", list);
  }
  if (content.gravity) append(text, "Gravity", "", formulas.gravity());
  if (content.equations) {
    append(text, "Equations of motion",
           "$\\frac{d}{dt} \\frac{\\partial L}{\\partial \\dot q} - "
           "\\frac{\\partial L}{\\partial q} = \\tau$, $L = T - V$.\n",
           formulas.equations(distinct(form.christoffel)));
  }
  text += "\\end{document}\n";
  return text;
}

}  // namespace geodesic::tools::derive
