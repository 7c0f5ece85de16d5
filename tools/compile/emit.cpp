// Head, tables and tail of an emitted file; see emit.hpp.
#include "tools/compile/emit.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tools/compile/abi.hpp"

namespace geodesic::tools::compile {
namespace {

/// As the inside of a string literal, and of a comment.
std::string harmless(const std::string& name) {
  std::string text;
  for (const char c : name) {
    const bool plain = (c >= ' ' && c <= '~' && c != '"' && c != '\\' && c != '?');
    text += plain ? c : '_';
  }
  return text;
}

std::string list(const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) text += fmt::format("{}{}", text.empty() ? "" : ", ", number);
  return text;
}

std::string head(const Emission& e) {
  std::string text = fmt::format(
      "// Dynamics of {} as straight-line code, for this one mechanism only.\n"
      "// Written by {}; do not edit: write it anew.\n"
      "// Fingerprint of the mechanism: {}\n//\n",
      harmless(e.robot), e.generator, e.fingerprint);
  text += "// function            multiplications   additions   divisions   angles\n";
  for (const Program& program : e.programs) {
    const Cost cost = program.cost();
    text += fmt::format("// {:<18}{:>17}{:>12}{:>12}{:>9}\n", program.name, cost.multiplications,
                        cost.additions, cost.divisions, cost.angles);
  }
  text +=
      "//\n// The digits in a name are the joint's number, x y z the component along its link's "
      "axes "
      "(z is\n// the joint's axis): sin, cos of the angle; w, dw angular velocity and its rate; a "
      "acceleration of\n// the origin, gravity included; up gravity alone; f, n force and moment "
      "the link needs; F, N with\n// all it carries; h first moment of all it carries.\n//\n";
  for (std::size_t i = 0; i < e.joint_names.size(); ++i) {
    text += fmt::format("//   {:>2}  {}\n", i + 1, harmless(e.joint_names[i]));
  }
  return text;
}

}  // namespace

std::string emit(const Emission& e) {
  std::string text = head(e);
  const int arms = 1 + std::max(*std::max_element(e.arm_of_q.begin(), e.arm_of_q.end()),
                                *std::max_element(e.arm_of_v.begin(), e.arm_of_v.end()));
  text += fmt::format(
      "\nnamespace {{\nconstexpr int kNq = {};\nconstexpr int kNv = {};\n"
      "constexpr int kArms = {};  // parts that share nothing\n"
      "constexpr unsigned char kArmOfQ[kNq] = {{{}}};\n"
      "constexpr unsigned char kArmOfV[kNv] = {{{}}};\n}}  // namespace\n",
      e.nq, e.nv, arms, list(e.arm_of_q), list(e.arm_of_v));
  text += emit_preamble();
  for (const Program& program : e.programs) text += emit_function(program, e.nq, e.nv);
  std::string functions;
  for (const Program& program : e.programs) {
    functions += fmt::format(", geodesic_{}", program.name);
  }
  text += fmt::format(
      "\n#ifndef GEODESIC_ISA_LEVEL\n#define GEODESIC_ISA_LEVEL 0\n#endif\n\n"
      "extern \"C\" __attribute__((visibility(\"default\")))\n"
      "const geodesic_compiled* {}() {{\n"
      "  static const geodesic_compiled model = {{{}, GEODESIC_ISA_LEVEL, \"{}\",\n"
      "      \"{}\", kNq, kNv{}}};\n  return &model;\n}}\n",
      kCompiledSymbol, kCompiledAbi, harmless(e.robot), e.fingerprint, functions);
  return text;
}

}  // namespace geodesic::tools::compile
