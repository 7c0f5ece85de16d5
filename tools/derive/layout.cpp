// Polynomials in writing; see the header.
#include "tools/derive/layout.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

namespace geodesic::tools::derive {
namespace {

using Kind = Letter::Kind;
using Powers = MonomialTable::Powers;

constexpr int kNoHead = -1;

template <typename Less>
std::vector<int> ranks(std::size_t count, const Less& less) {
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), less);
  std::vector<int> rank(count);
  for (std::size_t i = 0; i < count; ++i) {
    rank[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  return rank;
}

bool is_head(Kind kind) {
  return kind == Kind::kMass || kind == Kind::kInertia || kind == Kind::kRotor;
}

// The letters that all have in common, with the least exponent.
Powers common(const std::vector<Powers>& all) {
  Powers shared = all.front();
  for (const Powers& powers : all) {
    Powers next;
    for (const auto& mine : shared) {
      for (const auto& theirs : powers) {
        if (theirs.letter == mine.letter) {
          next.push_back({mine.letter, std::min(mine.exponent, theirs.exponent)});
        }
      }
    }
    shared = next;
  }
  return shared;
}

Powers quotient(const Powers& powers, const Powers& divisor) {
  Powers result;
  for (auto power : powers) {
    for (const auto& part : divisor) {
      if (part.letter == power.letter) power.exponent -= part.exponent;
    }
    if (power.exponent > 0) result.push_back(power);
  }
  return result;
}

}  // namespace

Layout::Layout(Symbols& symbols, Notation notation, int digits)
    : symbols_(&symbols), notation_(notation), digits_(digits) {
  const auto letter = [&](int i) -> const Letter& {
    return symbols.letters[static_cast<std::size_t>(i)];
  };
  rank_ = ranks(symbols.letters.size(), [&](int a, int b) {
    return std::tie(letter(a).kind, letter(a).body, letter(a).name) <
           std::tie(letter(b).kind, letter(b).body, letter(b).name);
  });
  head_rank_ = ranks(symbols.letters.size(), [&](int a, int b) {
    return std::tie(letter(a).body, letter(a).kind, letter(a).name) <
           std::tie(letter(b).body, letter(b).kind, letter(b).name);
  });
}

Powers Layout::ordered(Monomial monomial) const {
  Powers powers = symbols_->monomials.powers(monomial);
  std::sort(powers.begin(), powers.end(), [&](const auto& a, const auto& b) {
    return rank_[static_cast<std::size_t>(a.letter)] < rank_[static_cast<std::size_t>(b.letter)];
  });
  return powers;
}

int Layout::head(Monomial monomial) const {
  int best = kNoHead;
  for (const auto& power : symbols_->monomials.powers(monomial)) {
    const auto at = static_cast<std::size_t>(power.letter);
    if (!is_head(symbols_->letters[at].kind)) continue;
    if (best == kNoHead || head_rank_[at] < head_rank_[static_cast<std::size_t>(best)]) {
      best = power.letter;
    }
  }
  return best;
}

// By head, then by the letters of the product: high powers of the first letters first.
bool Layout::comes_first(const ProductTerm& a, const ProductTerm& b) const {
  const auto key = [&](const ProductTerm& term) {
    const int first = head(term.monomial);
    std::vector<int> list{first == kNoHead ? -1 : head_rank_[static_cast<std::size_t>(first)]};
    for (const auto& power : ordered(term.monomial)) {
      list.push_back(rank_[static_cast<std::size_t>(power.letter)]);
      list.push_back(-power.exponent);
    }
    return list;
  };
  return key(a) < key(b);
}

std::string Layout::number(double value) const {
  if (notation_ == Notation::kPlain) return fmt::format("{}", value);
  std::string text = fmt::format("{:.{}g}", value, digits_);
  const std::size_t exponent = text.find('e');
  if (notation_ == Notation::kLatex && exponent != std::string::npos) {
    return fmt::format("{} \\cdot 10^{{{}}}", text.substr(0, exponent),
                       std::stoi(text.substr(exponent + 1)));
  }
  return text;
}

// Halves and the like of letters are written as fractions.
std::string Layout::coefficient(double magnitude, bool alone, bool with_letters) const {
  if (magnitude == 1.0 && !alone) return "";
  for (const int divisor : {2, 3, 4, 6, 8, 12, 16}) {
    const double part = magnitude * divisor;
    if (!with_letters || notation_ == Notation::kPlain) break;
    if (part == std::round(part) && magnitude != std::round(magnitude) && part < 100.0) {
      return fmt::format(
          fmt::runtime(notation_ == Notation::kLatex ? "\\frac{{{}}}{{{}}}" : "{}/{}"),
          static_cast<int>(part), divisor);
    }
  }
  return number(magnitude);
}

std::string Layout::power(const std::string& base, int exponent) const {
  if (exponent == 1) return base;
  return fmt::format(fmt::runtime(notation_ == Notation::kLatex ? "{}^{{{}}}" : "{}^{}"), base,
                     exponent);
}

std::string Layout::wave(const TrigPower& factor) const {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < symbols_->angles.size(); ++i) {
    if (factor.wave[i] == 0) continue;
    const Angle& angle = symbols_->angles[i];
    const double multiple = factor.wave[i] * angle.ratio;
    const Coordinate& q = symbols_->coordinates[static_cast<std::size_t>(angle.dof)];
    std::string part = multiple < 0.0 ? "-" : "";
    if (std::abs(multiple) != 1.0) {
      part += number(std::abs(multiple));
      part += notation_ == Notation::kPlain ? "*" : " ";
    }
    parts.push_back(part + (notation_ == Notation::kLatex ? q.latex : q.name));
  }
  const std::string argument = signed_sum(parts);
  const bool bare = notation_ != Notation::kPlain && argument.find(' ') == std::string::npos;
  std::string name = factor.sine ? "sin" : "cos";
  if (notation_ == Notation::kLatex) name.insert(0, "\\");
  if (notation_ == Notation::kPlain) {
    return power(fmt::format("{}({})", name, argument), factor.exponent);
  }
  return fmt::format(fmt::runtime(bare ? "{} {}" : "{}({})"), power(name, factor.exponent),
                     argument);
}

// Sign, coefficient, bracket, letters, waves.
std::string Layout::term(const ProductTerm& term, const std::string& bracket) const {
  std::vector<std::string> parts;
  const Powers powers = ordered(term.monomial);
  bool letters = !bracket.empty();
  for (const auto& factor : powers) {
    const Letter& letter = symbols_->letters[static_cast<std::size_t>(factor.letter)];
    letters = letters || letter.kind != Kind::kCoordinate;
    parts.push_back(
        power(notation_ == Notation::kLatex ? letter.latex : letter.name, factor.exponent));
  }
  if (!bracket.empty()) {
    // A mass before what it multiplies, other letters behind.
    const bool mass = !powers.empty() && head(term.monomial) != kNoHead;
    parts.insert(parts.begin() + (mass ? 1 : 0), fmt::format("({})", bracket));
  }
  for (const TrigPower& factor : term.factors) parts.push_back(wave(factor));
  const std::string factor = coefficient(std::abs(term.value), parts.empty(), letters);
  if (!factor.empty()) parts.insert(parts.begin(), factor);
  const char* separator = notation_ == Notation::kPlain ? "*" : " ";
  return fmt::format("{}{}", term.value < 0.0 ? "-" : "", fmt::join(parts, separator));
}

std::string Layout::sum(const Terms& terms) const {
  std::vector<std::string> parts;
  parts.reserve(terms.size());
  for (const ProductTerm& summand : terms) parts.push_back(term(summand));
  return signed_sum(parts);
}

std::string Layout::gathered_by_mass(const Terms& terms) const {
  std::map<int, Terms> groups;
  std::map<int, int> letter_of;
  for (const ProductTerm& term : terms) {
    const int first = head(term.monomial);
    const int rank = first == kNoHead ? -1 : head_rank_[static_cast<std::size_t>(first)];
    letter_of[rank] = first;
    groups[rank].push_back(term);
  }
  std::vector<std::string> parts;
  for (auto& [rank, group] : groups) {
    if (rank < 0 || group.size() == 1) {
      for (const ProductTerm& summand : group) parts.push_back(term(summand));
      continue;
    }
    ProductTerm outside{0, group.front().value < 0.0 ? -1.0 : 1.0, {}};
    const Powers mass{{letter_of[rank], 1}};
    MonomialTable& table = symbols_->monomials;
    outside.monomial = table.intern(mass);
    for (ProductTerm& inside : group) {
      inside.value *= outside.value;
      inside.monomial = table.intern(quotient(table.powers(inside.monomial), mass));
    }
    parts.push_back(term(outside, sum(group)));
  }
  return signed_sum(parts);
}

std::string Layout::gathered_by_wave(const Terms& terms) const {
  std::vector<std::string> parts;
  for (auto first = terms.begin(); first != terms.end();) {
    const auto last = std::find_if(first, terms.end(), [&](const ProductTerm& term) {
      return term.factors != first->factors;
    });
    Terms group(first, last);
    first = last;
    if (group.size() == 1 || group.front().factors.empty()) {
      for (const ProductTerm& summand : group) parts.push_back(term(summand));
      continue;
    }
    MonomialTable& table = symbols_->monomials;
    std::vector<Powers> all;
    for (const ProductTerm& member : group) all.push_back(table.powers(member.monomial));
    const Powers shared = common(all);
    const double magnitude = std::abs(group.front().value);
    const bool equal = std::all_of(group.begin(), group.end(), [&](const ProductTerm& member) {
      return std::abs(member.value) == magnitude;
    });
    ProductTerm outside{table.intern(shared), equal ? magnitude : 1.0, group.front().factors};
    if (group.front().value < 0.0) outside.value = -outside.value;
    for (ProductTerm& inside : group) {
      inside.value /= outside.value;
      inside.factors.clear();
      inside.monomial = table.intern(quotient(table.powers(inside.monomial), shared));
    }
    parts.push_back(term(outside, sum(group)));
  }
  return signed_sum(parts);
}

std::string Layout::write(const Polynomial& polynomial, Gather gather) const {
  Terms terms = shortest_form(polynomial);
  // Waves keep their order, and within the same waves letters decide.
  for (auto first = terms.begin(); first != terms.end();) {
    const auto last = std::find_if(first, terms.end(), [&](const ProductTerm& term) {
      return term.factors != first->factors;
    });
    std::stable_sort(first, last,
                     [&](const ProductTerm& a, const ProductTerm& b) { return comes_first(a, b); });
    first = last;
  }
  return gather == Gather::kMass ? gathered_by_mass(terms) : gathered_by_wave(terms);
}

std::string wrapped(const std::string& text, std::size_t width, const std::string& indent) {
  std::string result;
  std::size_t line = 0;      // where the current line begins
  std::size_t possible = 0;  // the last space that it may be broken at
  std::size_t depth = 0;     // of brackets around an argument, which stays whole
  const auto break_if_long = [&](std::size_t end) {
    if (end - line <= width || possible <= line) return;
    result += text.substr(line, possible - line);
    result += "\n";
    result += indent;
    line = possible + 1;
  };
  for (std::size_t i = 1; i + 2 < text.size(); ++i) {
    if (text[i] == '(' && (depth > 0 || (text[i - 1] != ' ' && text[i - 1] != '-'))) ++depth;
    if (text[i] == ')' && depth > 0) --depth;
    const bool sign = text[i + 1] == '+' || text[i + 1] == '-';
    if (depth > 0 || text[i] != ' ' || !sign || text[i + 2] != ' ') continue;
    break_if_long(i);
    possible = i;
  }
  break_if_long(text.size());
  return result + text.substr(line);
}

std::string signed_sum(const std::vector<std::string>& terms) {
  if (terms.empty()) return "0";
  std::string result = terms.front();
  for (std::size_t i = 1; i < terms.size(); ++i) {
    const bool negative = terms[i].starts_with('-');
    result += negative ? " - " : " + ";
    result += negative ? terms[i].substr(1) : terms[i];
  }
  return result;
}

}  // namespace geodesic::tools::derive
