// A cycle on the wire for people; see the header.
#include "tools/geodesic/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "tools/geodesic/picture.hpp"
#include "tools/geodesic/timeline_plot_script.hpp"  // made of timeline_plot.py

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

double us(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-3;
}

/// Frames in the order in which they are on the wire.
std::vector<std::size_t> by_time(const drivers::CyclePlan& plan) {
  std::vector<std::size_t> order(plan.frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return plan.worst.frames[a].start_ns < plan.worst.frames[b].start_ns;
  });
  return order;
}

std::string id_text(const drivers::CyclicFrame& frame) {
  return frame.extended ? fmt::format("0x{:08X}", frame.id) : fmt::format("0x{:03X}", frame.id);
}

/// What of `limit_hz` is left once the drives' time to answer is counted.
double share_of_limit(const drivers::CyclePlan& plan) {
  return plan.reachable_hz() / plan.limit_hz();
}

void print_frames(const config::Robot& robot, const config::BusLoad& load) {
  const drivers::CyclePlan& plan = load.plan;
  std::size_t width = 5;
  for (const std::size_t joint : plan.order) {
    width = std::max(width, robot.arm.joints[joint].name.size());
  }
  fmt::print("{:>10}{:>9}{:>11}{:>12}  {:<{}}  {:<18}{:>5}{:>9}\n", "from [us]", "to", "(no stuff)",
             "id", "drive", width, "frame", "bytes", "slack");
  for (const std::size_t i : by_time(plan)) {
    const drivers::PlannedFrame& planned = plan.frames[i];
    const drivers::WireTime& time = plan.worst.frames[i];
    const std::string what =
        fmt::format("{} {}", planned.frame.reply ? "<-" : "->", planned.frame.what);
    const std::string slack =
        planned.frame.reply ? fmt::format("{:.1f}", us(load.deadline_ns - time.end_ns)) : "";
    fmt::print("{:>10.1f}{:>9.1f}{:>11.1f}{:>12}  {:<{}}  {:<18}{:>5}{:>9}\n", us(time.start_ns),
               us(time.end_ns), us(plan.best.frames[i].end_ns), id_text(planned.frame),
               robot.arm.joints[planned.joint].name, width, what, planned.frame.bytes, slack);
  }
}

void print_summary(const config::BusLoad& load) {
  const drivers::CyclePlan& plan = load.plan;
  const std::int64_t period_ns = plan.budget.period_ns;
  fmt::print(
      "the last reply ends at {:.1f} us ({:.1f} without stuff bits): {:.1f} us of slack until "
      "replies count as lost at {:.1f} us, {:.1f} us ({:.1f} %) of headroom until the next cycle\n",
      us(plan.worst.end_ns), us(plan.best.end_ns), us(load.deadline_ns - plan.worst.end_ns),
      us(load.deadline_ns), us(period_ns - plan.worst.end_ns),
      100.0 * static_cast<double>(period_ns - plan.worst.end_ns) / static_cast<double>(period_ns));
  fmt::print(
      "replies follow each other within {:.1f} us; the wire waits {:.1f} us for drives that answer "
      "in {:.0f} us; {:.0f} Hz of the {:.0f} Hz that bit timing allows ({:.1f} %)\n",
      us(plan.worst.gap_ns), us(plan.worst.idle_ns()), us(plan.latency_ns), plan.reachable_hz(),
      plan.limit_hz(), 100.0 * share_of_limit(plan));
  const std::size_t collisions = std::max(plan.best.collisions, plan.worst.collisions);
  if (collisions > 0) {
    fmt::print(
        "CAREFUL: {} times a cycle two frames of one identifier wait for the wire at once "
        "and destroy each other: give the drives identifiers of their own\n",
        collisions);
  }
}

}  // namespace

ordered_json timeline_json(const config::Robot& robot, std::size_t bus,
                           const config::BusLoad& load) {
  const drivers::CyclePlan& plan = load.plan;
  ordered_json order = ordered_json::array();
  for (const std::size_t joint : plan.order) order.push_back(robot.arm.joints[joint].name);
  ordered_json frames = ordered_json::array();
  for (const std::size_t i : by_time(plan)) {
    const drivers::PlannedFrame& planned = plan.frames[i];
    const drivers::WireTime& worst = plan.worst.frames[i];
    const drivers::WireTime& best = plan.best.frames[i];
    ordered_json frame{{"joint", robot.arm.joints[planned.joint].name},
                       {"what", planned.frame.what},
                       {"reply", planned.frame.reply},
                       {"id", planned.frame.id},
                       {"extended", planned.frame.extended},
                       {"bytes", planned.frame.bytes},
                       {"share", planned.frame.share},
                       {"ready_us", us(worst.ready_ns)},
                       {"start_us", us(worst.start_ns)},
                       {"end_us", us(worst.end_ns)},
                       {"best_start_us", us(best.start_ns)},
                       {"best_end_us", us(best.end_ns)}};
    if (planned.frame.reply) frame["slack_us"] = us(load.deadline_ns - worst.end_ns);
    frames.push_back(std::move(frame));
  }
  return {{"bus", robot.arm.buses[bus].name},
          {"period_us", us(plan.budget.period_ns)},
          {"deadline_us", us(load.deadline_ns)},
          {"latency_us", us(plan.latency_ns)},
          {"busy_us", us(plan.worst.busy_ns)},
          {"end_us", us(plan.worst.end_ns)},
          {"best_end_us", us(plan.best.end_ns)},
          {"bound_us", us(plan.bound_ns())},
          {"idle_us", us(plan.worst.idle_ns())},
          {"reply_gap_us", us(plan.worst.gap_ns)},
          {"slack_us", us(load.deadline_ns - plan.worst.end_ns)},
          {"headroom_us", us(plan.budget.period_ns - plan.worst.end_ns)},
          {"limit_hz", plan.limit_hz()},
          {"reachable_hz", plan.reachable_hz()},
          {"collisions", std::max(plan.best.collisions, plan.worst.collisions)},
          {"order", std::move(order)},
          {"frames", std::move(frames)}};
}

void print_timelines(const config::Robot& robot, const config::BudgetReport& budget) {
  for (const config::BusLoad& load : budget.buses) {
    if (load.plan.frames.empty()) continue;
    fmt::print("\na cycle on bus {}, at worst:\n", load.name);
    print_frames(robot, load);
    print_summary(load);
  }
}

void draw_timelines(const config::Robot& robot, const config::BudgetReport& budget,
                    const std::string& file) {
  ordered_json buses = ordered_json::array();
  for (std::size_t i = 0; i < budget.buses.size(); ++i) {
    if (budget.buses[i].plan.frames.empty()) continue;
    buses.push_back(timeline_json(robot, i, budget.buses[i]));
  }
  draw_picture(kTimelinePlotScript,
               {{"robot", robot.name},
                {"rate_hz", 1e9 / static_cast<double>(robot.period_ns)},
                {"buses", std::move(buses)}},
               file, "--json prints the figures without");
}

}  // namespace geodesic::tools
