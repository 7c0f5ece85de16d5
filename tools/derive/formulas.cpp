// Left and right sides; see the header.
#include "tools/derive/formulas.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <map>

namespace geodesic::tools::derive {

// A polynomial's terms in order, for looking it up: by its number of terms and first key.
Connection distinct(const std::vector<std::vector<std::vector<Polynomial>>>& symbols) {
  Connection result;
  std::multimap<std::pair<std::size_t, Key>, int> known;
  const auto n = static_cast<int>(symbols.size());
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = j; k < n; ++k) {
        const Polynomial& symbol = symbols[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]
                                          [static_cast<std::size_t>(k)];
        if (symbol.is_zero()) continue;
        const std::pair<std::size_t, Key> hint{symbol.terms().size(), symbol.terms().front().key};
        SymbolOfConnection entry{i, j, k, -1, 1};
        const auto [first, last] = known.equal_range(hint);
        for (auto candidate = first; candidate != last && entry.value < 0; ++candidate) {
          const Polynomial& value = result.values[static_cast<std::size_t>(candidate->second)];
          const bool equal = same(value, symbol);
          if (!equal && !same(value, -1.0L * symbol)) continue;
          entry.value = candidate->second;
          entry.sign = equal ? 1 : -1;
        }
        if (entry.value < 0) {
          entry.value = static_cast<int>(result.values.size());
          known.emplace(hint, entry.value);
          result.values.push_back(symbol);
        }
        result.symbols.push_back(entry);
      }
    }
  }
  return result;
}

Formulas::Formulas(ClosedForm& form, Notation notation, int digits)
    : form_(&form), layout_(form.symbols, notation, digits) {}

// M12, and with ten joints or more M1,12; M_{12}.
std::string Formulas::name(const std::string& letter, const std::vector<int>& indices) const {
  std::vector<int> from_one;
  from_one.reserve(indices.size());
  for (const int index : indices) from_one.push_back(index + 1);
  const std::string list =
      fmt::format("{}", fmt::join(from_one, form_->n > 9 && from_one.size() > 1 ? "," : ""));
  if (layout_.notation() == Notation::kLatex) return fmt::format("{}_{{{}}}", letter, list);
  return fmt::format("{}{}", letter, list);
}

std::string Formulas::product(const std::string& a, const std::string& b) const {
  return fmt::format("{}{}{}", a, layout_.notation() == Notation::kPlain ? "*" : " ", b);
}

std::string Formulas::value_name(const Connection& connection, const std::string& letter,
                                 int value) const {
  if (connection.values.size() == 1) return letter;
  const bool latex = layout_.notation() == Notation::kLatex;
  return fmt::format(fmt::runtime(latex ? "{}_{{{}}}" : "{}{}"), letter, value + 1);
}

std::vector<Formula> Formulas::metric() const {
  std::vector<Formula> list;
  for (int i = 0; i < form_->n; ++i) {
    for (int j = i; j < form_->n; ++j) {
      const Polynomial& entry =
          form_->metric[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      std::string left = name("M", {i, j});
      if (i != j) left = fmt::format("{} = {}", left, name("M", {j, i}));
      list.push_back({left, layout_.write(entry, Gather::kMass)});
    }
  }
  return list;
}

std::vector<Formula> Formulas::gravity() const {
  std::vector<Formula> list;
  list.reserve(form_->gravity.size());
  for (int i = 0; i < form_->n; ++i) {
    list.push_back({name("g", {i}),
                    layout_.write(form_->gravity[static_cast<std::size_t>(i)], Gather::kWave)});
  }
  return list;
}

std::vector<Formula> Formulas::values(const Connection& connection,
                                      const std::string& letter) const {
  std::vector<Formula> list;
  for (std::size_t i = 0; i < connection.values.size(); ++i) {
    list.push_back({value_name(connection, letter, static_cast<int>(i)),
                    layout_.write(connection.values[i], Gather::kWave)});
  }
  return list;
}

std::vector<Formula> Formulas::symbols(const Connection& connection, const std::string& letter,
                                       bool second_kind) const {
  const bool latex = layout_.notation() == Notation::kLatex;
  std::map<std::pair<int, int>, std::vector<std::string>> names;  // value, sign -> symbols
  for (const SymbolOfConnection& symbol : connection.symbols) {
    const std::string upper = std::to_string(symbol.i + 1);
    const char* comma = form_->n > 9 ? "," : "";
    const std::string lower = fmt::format("{}{}{}", symbol.j + 1, comma, symbol.k + 1);
    const char* pattern = latex ? (second_kind ? "\\Gamma^{{{}}}_{{{}}}" : "\\Gamma_{{{},{}}}")
                                : (second_kind ? "Γ^{}_{}" : "Γ{},{}");
    names[{symbol.value, -symbol.sign}].push_back(fmt::format(fmt::runtime(pattern), upper, lower));
  }
  std::vector<Formula> list;
  for (const auto& [key, equal] : names) {
    std::string right = key.second > 0 ? "-" : "";
    right += value_name(connection, letter, key.first);
    if (second_kind) {
      right = latex ? fmt::format("{} / \\det M", right) : fmt::format("{} / det M", right);
    }
    list.push_back({fmt::format("{}", fmt::join(equal, " = ")), right});
  }
  return list;
}

std::string Formulas::rates(int j, int k, int factor) const {
  const bool latex = layout_.notation() == Notation::kLatex;
  const auto rate = [&](int index) { return name(latex ? "\\dot q" : "v", {index}); };
  std::string text = j == k ? fmt::format(fmt::runtime(latex ? "{}^{{2}}" : "{}^2"), rate(j))
                            : product(rate(j), rate(k));
  const int magnitude = std::abs(factor) * (j == k ? 1 : 2);
  if (magnitude != 1) text = product(std::to_string(magnitude), text);
  return factor < 0 ? fmt::format("-{}", text) : text;
}

std::vector<Formula> Formulas::equations(const Connection& connection) const {
  const bool latex = layout_.notation() == Notation::kLatex;
  std::vector<Formula> list;
  for (int i = 0; i < form_->n; ++i) {
    std::vector<std::string> sum;
    for (int j = 0; j < form_->n; ++j) {
      const auto row = static_cast<std::size_t>(std::min(i, j));
      const auto column = static_cast<std::size_t>(std::max(i, j));
      if (form_->metric[row][column].is_zero()) continue;
      sum.push_back(product(name("M", {std::min(i, j), std::max(i, j)}),
                            name(latex ? "\\ddot q" : "a", {j})));
    }
    std::map<int, std::vector<std::string>> of_value;
    for (const SymbolOfConnection& symbol : connection.symbols) {
      if (symbol.i != i) continue;
      of_value[symbol.value].push_back(rates(symbol.j, symbol.k, symbol.sign));
    }
    for (auto& [value, terms] : of_value) {
      const std::string factor = value_name(connection, "h", value);
      const bool negative = std::all_of(terms.begin(), terms.end(), [](const std::string& term) {
        return term.starts_with('-');
      });
      for (std::string& term : terms) {
        if (negative) term.erase(0, 1);
      }
      const std::string text = product(
          factor, terms.size() == 1 ? terms.front() : fmt::format("({})", signed_sum(terms)));
      sum.push_back(negative ? fmt::format("-{}", text) : text);
    }
    if (!form_->gravity[static_cast<std::size_t>(i)].is_zero()) sum.push_back(name("g", {i}));
    list.push_back({name(latex ? "\\tau" : "tau", {i}), signed_sum(sum)});
  }
  return list;
}

Formula Formulas::determinant() const {
  return {layout_.notation() == Notation::kLatex ? "\\det M" : "det M",
          layout_.write(form_->determinant, Gather::kMass)};
}

}  // namespace geodesic::tools::derive
