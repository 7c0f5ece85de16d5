// One function as straight-line code: each node once, in an order in which all it needs stands
// before it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tools/compile/emit.hpp"

namespace geodesic::tools::compile {
namespace {

constexpr int kLanes = 8;
/// Operations used once are written where they are used, as long as a line stays readable.
constexpr std::size_t kLongestInline = 60;

std::string literal(double value) {
  std::string text = fmt::format("{:.17g}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

/// All angles whose sine or cosine counts, each with its lane: joints' own first, then sums.
class LanePlan {
 public:
  LanePlan(const Graph& graph, const std::vector<bool>& live) {
    std::set<int> wanted;
    for (std::size_t i = 0; i < live.size(); ++i) {
      const Node& node = graph.nodes()[i];
      if (live[i] && (node.op == Op::kSine || node.op == Op::kCosine)) wanted.insert(node.a);
    }
    for (const int angle : wanted) {
      for (const JointAngle& joint : graph.angles()[static_cast<std::size_t>(angle)]) {
        if (std::find(joints_.begin(), joints_.end(), joint) == joints_.end()) {
          joints_.push_back(joint);
        }
      }
    }
    std::stable_sort(joints_.begin(), joints_.end(), [](const JointAngle& a, const JointAngle& b) {
      return a.coordinate < b.coordinate;
    });
    lanes_ = static_cast<int>(joints_.size());
    for (const int angle : wanted) {
      const Angle& parts = graph.angles()[static_cast<std::size_t>(angle)];
      if (parts.size() == 1) {
        lane_of_[angle] = lane_of(parts.front());
      } else {
        sums_.emplace_back(lanes_, parts);
        lane_of_[angle] = lanes_++;
      }
    }
  }

  int lanes() const { return lanes_; }
  int vectors() const { return (lanes_ + kLanes - 1) / kLanes; }
  int lane(int angle) const { return lane_of_.at(angle); }

  /// Statements that fill the vectors angle0, angle1, ...
  std::string fill() const {
    std::string text;
    for (int k = 0; k < vectors(); ++k) text += load(k);
    return text;
  }
  /// ... and their lanes that are sums: of what the arrays hold, or of lanes that were brought
  /// near.
  std::string add_up(bool from_lanes) const {
    std::string text;
    for (const auto& [lane, parts] : sums_) {
      std::string sum;
      double offset = 0.0;
      for (const JointAngle& part : parts) {
        sum += sum.empty() ? "" : " + ";
        if (from_lanes) {
          sum += element("angle", lane_of(part));
        } else {
          if (part.rate != 1.0) sum += fmt::format("({}) * ", literal(part.rate));
          sum += fmt::format("q[{}]", part.coordinate);
          offset += part.offset;
        }
      }
      if (!from_lanes && offset != 0.0) sum += fmt::format(" + ({})", literal(offset));
      text += fmt::format("{}  put<{}>(angle{}, {});\n", from_lanes ? "  " : "", lane % kLanes,
                          lane / kLanes, sum);
    }
    return text;
  }

  static std::string element(const char* vector, int lane) {
    return fmt::format("{}{}[{}]", vector, lane / kLanes, lane % kLanes);
  }

 private:
  int lane_of(const JointAngle& joint) const {
    return static_cast<int>(std::find(joints_.begin(), joints_.end(), joint) - joints_.begin());
  }

  std::string load(int vector) const {
    const int first = vector * kLanes;
    const int last = std::min(first + kLanes, static_cast<int>(joints_.size()));
    const std::string name = fmt::format("angle{}", vector);
    if (first >= last) return fmt::format("  Lanes {} = {{}};\n", name);
    bool in_a_row = true;
    bool rates = false;
    bool offsets = false;
    std::string gathered, rate, offset;
    for (int lane = first; lane < last; ++lane) {
      const JointAngle& joint = joints_[static_cast<std::size_t>(lane)];
      in_a_row &=
          joint.coordinate == joints_[static_cast<std::size_t>(first)].coordinate + (lane - first);
      rates |= joint.rate != 1.0;
      offsets |= joint.offset != 0.0;
      const char* comma = lane == first ? "" : ", ";
      gathered += fmt::format("{}q[{}]", comma, joint.coordinate);
      rate += comma + literal(joint.rate);
      offset += comma + literal(joint.offset);
    }
    std::string text = in_a_row
                           ? fmt::format("  Lanes {} = load<{}>(q + {});\n", name, last - first,
                                         joints_[static_cast<std::size_t>(first)].coordinate)
                           : fmt::format("  Lanes {} = {{{}}};\n", name, gathered);
    if (rates) text += fmt::format("  {} *= Lanes{{{}}};\n", name, rate);
    if (offsets) text += fmt::format("  {} += Lanes{{{}}};\n", name, offset);
    return text;
  }

  std::vector<JointAngle> joints_;
  std::vector<std::pair<int, Angle>> sums_;
  std::map<int, int> lane_of_;
  int lanes_ = 0;
};

class Writer {
 public:
  Writer(const Program& program)  // NOLINT: one use, here
      : program_(program),
        nodes_(program.graph->nodes()),
        live_(live_nodes(*program.graph, program.outputs)),
        plan_(*program.graph, live_),
        uses_(nodes_.size(), 0),
        text_of_(nodes_.size()) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!live_[i] || nodes_[i].op < Op::kAdd) continue;
      ++uses_[static_cast<std::size_t>(nodes_[i].a)];
      if (nodes_[i].op != Op::kReciprocal) ++uses_[static_cast<std::size_t>(nodes_[i].b)];
    }
    for (const Number& output : program.outputs) {
      // Outputs are statements of their own.
      if (!output.is_constant()) uses_[static_cast<std::size_t>(output.node())] += 2;
    }
  }

  std::string write(int nq, int nv) {
    std::string text = head();
    text += guard(nq, nv);
    if (plan_.lanes() > 0) text += sines();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (live_[i]) text += statement(i);
    }
    for (std::size_t i = 0; i < program_.outputs.size(); ++i) {
      const Number& output = program_.outputs[i];
      const std::string value = output.is_constant()
                                    ? literal(output.value())
                                    : text_of_[static_cast<std::size_t>(output.node())];
      text += fmt::format("  out[{}] = {}{};\n", i, output.negative() ? "-" : "", value);
    }
    text += fmt::format("  if (__builtin_expect(odd, 0)) spoil(q, {}, {}, out, {});\n}}\n",
                        has(Array::kV) ? "v" : "nullptr", has(Array::kA) ? "a" : "nullptr",
                        program_.outputs.size() > static_cast<std::size_t>(nv));
    return text;
  }

 private:
  bool has(Array array) const {
    const auto& list = program_.arguments;
    return std::find(list.begin(), list.end(), array) != list.end();
  }

  std::string head() const {
    const Cost cost = program_.cost();
    std::string arguments;
    for (const Array array : program_.arguments) {
      arguments += fmt::format("const double* __restrict {}, ", to_string(array));
    }
    return fmt::format(
        "\n// {} multiplications, {} additions, {} divisions; {} angles.\n"
        "extern \"C\" __attribute__((visibility(\"hidden\")))\n"
        "void geodesic_{}({}double* __restrict out) {{\n",
        cost.multiplications, cost.additions, cost.divisions, cost.angles, program_.name,
        arguments);
  }

  std::string guard(int nq, int nv) const {
    std::string text = plan_.fill();
    text += fmt::format("  const bool odd = is_odd<{}>(q)", nq);
    if (has(Array::kV)) text += fmt::format(" | is_odd<{}>(v)", nv);
    if (has(Array::kA)) text += fmt::format(" | is_odd<{}>(a)", nv);
    text += ";\n";
    if (plan_.vectors() == 0) return text;
    text += plan_.add_up(false);
    std::string far;
    std::string near;
    for (int k = 0; k < plan_.vectors(); ++k) {
      far += fmt::format("{}is_far(angle{})", k == 0 ? "" : " | ", k);
      near += fmt::format("    bring_near(&angle{});\n", k);
    }
    return text + fmt::format("  if (__builtin_expect({}, 0)) {{\n{}{}  }}\n", far, near,
                              plan_.add_up(true));
  }

  std::string sines() const {
    std::string text;
    for (int k = 0; k < plan_.vectors(); ++k) {
      text += fmt::format(
          "  Lanes sine{0}, cosine{0};\n  sine_cosine(angle{0}, sine{0}, cosine{0});\n", k);
    }
    return text;
  }

  /// A name of its own, after what it stands for where that is known.
  std::string new_name(std::size_t i) {
    const std::string& wish = program_.graph->name_of(static_cast<int>(i));
    if (wish.empty()) return fmt::format("t{}", ++unnamed_);
    const int times = ++taken_[wish];
    return times == 1 ? wish : fmt::format("{}_{}", wish, times);
  }

  std::string statement(std::size_t i) {
    const Node& node = nodes_[i];
    std::string value;
    switch (node.op) {
      case Op::kConstant:
        text_of_[i] = literal(node.value);
        return {};
      case Op::kInput:
        text_of_[i] = fmt::format("{}[{}]", to_string(static_cast<Array>(node.a)), node.b);
        return {};
      case Op::kSine:
        value = LanePlan::element("sine", plan_.lane(node.a));
        break;
      case Op::kCosine:
        value = LanePlan::element("cosine", plan_.lane(node.a));
        break;
      case Op::kReciprocal:
        value = fmt::format("1.0 / {}", factor(node.a));
        break;
      case Op::kAdd:
        value = fmt::format("{} + {}", term(node.a), term(node.b));
        break;
      case Op::kSubtract:
        value = fmt::format("{} - {}", term(node.a), factor(node.b, true));
        break;
      case Op::kMultiply:
        value = fmt::format("{} * {}", factor(node.a), factor(node.b));
        break;
    }
    const bool own_line = uses_[i] != 1 || value.size() > kLongestInline || node.op < Op::kAdd;
    if (!own_line) {
      text_of_[i] = value;
      return {};
    }
    text_of_[i] = new_name(i);
    return fmt::format("  const double {} = {};\n", text_of_[i], value);
  }

  /// An operand of a sum: brackets would only say what stands there anyway.
  std::string term(int node) const { return text_of_[static_cast<std::size_t>(node)]; }

  /// An operand of a product, or one that is subtracted.
  std::string factor(int node, bool subtracted = false) const {
    const std::string& text = text_of_[static_cast<std::size_t>(node)];
    const Op op = nodes_[static_cast<std::size_t>(node)].op;
    const bool is_sum = op == Op::kAdd || op == Op::kSubtract;
    const bool compound = text.find(' ') != std::string::npos;
    return compound && (is_sum || !subtracted) ? "(" + text + ")" : text;
  }

  const Program& program_;
  const std::vector<Node>& nodes_;
  std::vector<bool> live_;
  LanePlan plan_;
  std::vector<int> uses_;
  std::vector<std::string> text_of_;
  std::map<std::string, int> taken_;
  int unnamed_ = 0;
};

}  // namespace

std::string emit_function(const Program& program, int nq, int nv) {
  return Writer(program).write(nq, nv);
}

}  // namespace geodesic::tools::compile
