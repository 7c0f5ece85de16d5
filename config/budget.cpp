// Bus time of a robot, and its refusal where a bus cannot carry it; see budget.hpp.
#include "config/budget.hpp"

#include <fmt/format.h>

#include <cmath>

#include "config/checks.hpp"
#include "drivers/families.hpp"

namespace geodesic::config {
namespace {

double us(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-3;
}

/// "8 commands * 56.4 us + 8 replies * 56.4 us", frames of one kind and length together.
class Sum {
 public:
  void add(const char* what, std::size_t bytes, std::int64_t worst) {
    for (Term& term : terms_) {
      if (term.what == what && term.bytes == bytes && term.worst_ns == worst) {
        ++term.count;
        return;
      }
    }
    terms_.push_back({what, bytes, worst, 1});
  }

  std::string text() const {
    std::string all;
    for (const Term& term : terms_) {
      all += fmt::format("{}{} {} of {} bytes * {:.1f} us", all.empty() ? "" : " + ", term.count,
                         term.what, term.bytes, us(term.worst_ns));
    }
    return all;
  }

 private:
  struct Term {
    std::string what;
    std::size_t bytes;
    std::int64_t worst_ns;
    std::size_t count;
  };
  std::vector<Term> terms_;
};

std::string rate_text(const drivers::BusOptions& bus) {
  const auto mega = [](std::int64_t rate) { return static_cast<double>(rate) * 1e-6; };
  return bus.fd ? fmt::format("CAN FD {}/{} Mbit/s", mega(bus.bit_rate), mega(bus.data_bit_rate))
                : fmt::format("classic CAN {} Mbit/s", mega(bus.bit_rate));
}

BusLoad load_of(const Robot& robot, std::size_t index) {
  const drivers::BusOptions& bus = robot.arm.buses[index];
  BusLoad load;
  load.name = bus.name;
  load.interface = bus.interface;
  for (const drivers::JointOptions& joint : robot.arm.joints) {
    const bool known = drivers::find_family(joint.drive.family) != nullptr;
    load.drives += known && joint.bus == index ? 1 : 0;
  }
  load.plan = drivers::plan_cycle(robot.arm, index, 1e9 / static_cast<double>(robot.period_ns),
                                  std::llround(robot.simulation.reply_latency_s * 1e9));
  load.deadline_ns =
      std::llround(robot.realtime.receive_deadline * static_cast<double>(robot.period_ns));
  Sum sum;
  for (const drivers::PlannedFrame& planned : load.plan.frames) {
    sum.add(planned.frame.reply ? "replies" : "commands", planned.frame.bytes,
            planned.wire.duration_ns);
  }
  const drivers::CyclePlan& plan = load.plan;
  const drivers::BusBudget& b = plan.budget;
  const std::string mean = b.worst_ns == plan.worst.busy_ns
                               ? std::string()
                               : fmt::format("; {:.1f} us on average", us(b.worst_ns));
  load.arithmetic = fmt::format(
      "{} drives, {}: {} = {:.1f} us a cycle at worst ({:.1f} us without stuff bits{}), {:.1f} % "
      "of the period of {:.1f} us; up to {:.0f} % may be used: {:.0f} Hz at most",
      load.drives, rate_text(bus), sum.text(), us(plan.worst.busy_ns), us(plan.best.busy_ns), mean,
      100.0 * b.worst_load, us(b.period_ns), 100.0 * b.usable, std::floor(b.max_rate_hz));
  return load;
}

}  // namespace

BudgetReport bus_budget(const Robot& robot) {
  BudgetReport report;
  for (std::size_t i = 0; i < robot.arm.buses.size(); ++i) {
    report.buses.push_back(load_of(robot, i));
    const BusLoad& load = report.buses.back();
    report.carried = report.carried && (load.drives == 0 || load.budget().carried);
  }
  return report;
}

void check_budget(Draft& draft) {
  const BudgetReport report = bus_budget(draft.robot);
  const double rate_hz = 1e9 / static_cast<double>(draft.robot.period_ns);
  for (std::size_t i = 0; i < report.buses.size(); ++i) {
    const BusLoad& load = report.buses[i];
    if (load.drives == 0) continue;
    const Given<double>& rate = draft.file.robot.rate_hz;
    if (!load.budget().carried) {
      draft.findings.error(
          rate.given ? rate.place : draft.file.buses[i].place,
          fmt::format(
              "rate_hz: bus {} cannot carry {:.6g} Hz: {}. Lower rate_hz, spread the drives "
              "over more buses, or use CAN FD",
              quote(load.name), rate_hz, load.arithmetic));
      continue;
    }
    const double deadline_us = draft.robot.realtime.receive_deadline * us(draft.robot.period_ns);
    if (us(load.budget().best_ns) > deadline_us) {
      const Given<double>& given = draft.file.realtime.receive_deadline;
      draft.findings.error(
          given.given ? given.place : draft.file.buses[i].place,
          fmt::format(
              "receive_deadline: {} of a period is {:.1f} us, but bus {} is busy for {:.1f} "
              "us a cycle even without stuff bits: the last replies would always count as "
              "lost. Raise receive_deadline or lower rate_hz",
              draft.robot.realtime.receive_deadline, deadline_us, quote(load.name),
              us(load.budget().best_ns)));
    } else if (load.plan.worst.end_ns > load.deadline_ns) {
      const Given<double>& given = draft.file.realtime.receive_deadline;
      draft.findings.warning(
          given.given ? given.place : draft.file.buses[i].place,
          fmt::format("receive_deadline: {} of a period is {:.1f} us, but the last reply on bus {} "
                      "may come "
                      "after {:.1f} us, which would count as lost. Raise receive_deadline",
                      draft.robot.realtime.receive_deadline, deadline_us, quote(load.name),
                      us(load.plan.worst.end_ns)));
    }
  }
}

}  // namespace geodesic::config
