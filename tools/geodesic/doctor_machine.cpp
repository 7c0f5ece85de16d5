// Kernel and processors under the doctor's eye; see doctor_looks.hpp.
#include <fmt/format.h>

#include <algorithm>

#include "tools/geodesic/doctor_looks.hpp"

namespace geodesic::tools {
namespace {

constexpr const char* kCpus = "/sys/devices/system/cpu";
constexpr long kLongSleepUs = 20;    ///< waking from deeper states takes longer than a cycle spares
constexpr double kLeastShare = 0.5;  ///< of the processor left to real-time threads

/// A kernel parameter, on distributions that boot by GRUB.
std::string boot_with(const std::string& parameters) {
  return fmt::format(
      "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&{} /' /etc/default/grub && sudo update-grub && sudo "
      "reboot",
      parameters);
}

void look_at_throttling(const SystemTree& system, Area& area) {
  const std::optional<long> runtime = system.read_number("/proc/sys/kernel/sched_rt_runtime_us");
  const long period = system.read_number("/proc/sys/kernel/sched_rt_period_us").value_or(1'000'000);
  if (!runtime) return;
  constexpr const char* kFix = "sudo sysctl -w kernel.sched_rt_runtime_us=950000";
  const std::string text =
      *runtime < 0 ? std::string("real-time threads may take all of a processor")
                   : fmt::format("real-time threads may take {} of {} us", *runtime, period);
  if (*runtime == 0) {
    area.bad("run time", text + ": none can start", kFix);
  } else if (*runtime > 0 &&
             static_cast<double>(*runtime) < kLeastShare * static_cast<double>(period)) {
    area.warn("run time", text + ", and are halted beyond", kFix);
  } else {
    area.ok("run time", text);
  }
}

void look_at_clock(const SystemTree& system, Area& area) {
  const std::optional<std::string> clock =
      system.read("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  if (!clock) return;
  const bool slow =
      *clock == "hpet" || *clock == "acpi_pm" || *clock == "jiffies" || *clock == "refined-jiffies";
  if (slow) {
    area.warn("clock", *clock + ": each reading of the clock costs a microsecond or more",
              boot_with("tsc=reliable"));
  } else {
    area.ok("clock", *clock);
  }
}

void look_at_governor(const SystemTree& system, const std::vector<int>& cpus, Area& area) {
  std::string slow;
  std::string governor;
  bool known = false;
  for (const int cpu : cpus) {
    const auto found = system.read(fmt::format("{}/cpu{}/cpufreq/scaling_governor", kCpus, cpu));
    known = known || found.has_value();
    if (!found || *found == "performance") continue;
    governor = *found;
    slow += fmt::format("{}{}", slow.empty() ? "" : ",", cpu);
  }
  if (!slow.empty()) {
    area.warn("governor",
              fmt::format("{} on processor {}: the clock rate follows the load, which a cycle is "
                          "too short to raise",
                          governor, slow),
              "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
  } else {
    area.ok("governor", known ? "performance" : "the kernel does not change the clock rate");
  }
}

void look_at_sleep(const SystemTree& system, const std::vector<int>& cpus, Area& area) {
  constexpr const char* kRequest = "/dev/cpu_dma_latency";
  long longest = 0;
  std::string name;
  for (const int cpu : cpus) {
    const std::string folder = fmt::format("{}/cpu{}/cpuidle", kCpus, cpu);
    for (const std::string& state : system.list(folder)) {
      const std::string place = fmt::format("{}/{}", folder, state);
      const long latency = system.read_number(place + "/latency").value_or(0);
      if (latency <= longest || system.read_number(place + "/disable").value_or(0) != 0) continue;
      longest = latency;
      name = system.read(place + "/name").value_or(state);
    }
  }
  if (longest <= kLongSleepUs) {
    area.ok("sleep states", longest == 0
                                ? std::string("none")
                                : fmt::format("the deepest, {}, wakes in {} us", name, longest));
  } else if (system.writable(kRequest)) {
    area.ok("sleep states",
            fmt::format("{} takes {} us to wake, but the daemon can hold it off ({})", name,
                        longest, kRequest));
  } else {
    area.warn("sleep states",
              fmt::format("{} takes {} us to wake, and {} is not this user's to hold it off", name,
                          longest, kRequest),
              "printf 'KERNEL==\"cpu_dma_latency\", OWNER=\"%s\"\\n' \"$USER\" | sudo tee "
              "/etc/udev/rules.d/90-geodesic.rules && sudo udevadm control --reload && sudo "
              "udevadm trigger --name-match=cpu_dma_latency");
  }
}

void look_at_isolation(const SystemTree& system, const Wishes& wishes,
                       const std::vector<int>& online, Area& area) {
  const std::vector<int> isolated =
      parse_cpu_list(system.read(fmt::format("{}/isolated", kCpus)).value_or(""));
  std::vector<int> absent;
  std::vector<int> shared;
  for (const int cpu : wishes.cpus) {
    if (std::find(online.begin(), online.end(), cpu) == online.end()) {
      absent.push_back(cpu);
    } else if (std::find(isolated.begin(), isolated.end(), cpu) == isolated.end()) {
      shared.push_back(cpu);
    }
  }
  if (!absent.empty()) {
    area.bad("isolation",
             fmt::format("[realtime] cpus names processor {}, which is not online ({} are)",
                         to_cpu_list(absent), to_cpu_list(online)),
             fmt::format("echo 1 | sudo tee {}/cpu{}/online", kCpus, absent.front()));
  } else if (!shared.empty()) {
    const std::string list = to_cpu_list(wishes.cpus);
    area.warn("isolation",
              fmt::format("processor {} of [realtime] cpus is open to every other program",
                          to_cpu_list(shared)),
              boot_with(fmt::format("isolcpus={0} nohz_full={0} rcu_nocbs={0}", list)));
  } else if (wishes.cpus.empty() && !isolated.empty()) {
    area.warn(
        "isolation",
        fmt::format("processor {} is set aside, but [realtime] cpus names none: the cycle "
                    "does not run there",
                    to_cpu_list(isolated)),
        fmt::format("add to the robot file, under [realtime]: cpus = [{}]", isolated.front()));
  } else {
    area.ok("isolation",
            wishes.cpus.empty()
                ? std::string("no processor is set aside, and none is asked for")
                : fmt::format("processor {} is the cycle's alone", to_cpu_list(wishes.cpus)));
  }
}

}  // namespace

void look_at_kernel(const SystemTree& system, Findings& findings) {
  Area area("kernel", findings);
  const std::string release = system.read("/proc/sys/kernel/osrelease").value_or("unknown");
  const std::string version = system.read("/proc/version").value_or("");
  const bool realtime = system.read_number("/sys/kernel/realtime") == 1 ||
                        version.find("PREEMPT_RT") != std::string::npos;
  if (realtime) {
    area.ok("PREEMPT_RT", release + ", fully preemptible");
  } else {
    area.warn("PREEMPT_RT",
              release +
                  " is not PREEMPT_RT: interrupts and drivers can hold a cycle up for "
                  "milliseconds",
              "sudo apt install linux-image-rt-$(dpkg --print-architecture) && sudo reboot");
  }
  look_at_throttling(system, area);
  look_at_clock(system, area);
}

void look_at_processors(const SystemTree& system, const Wishes& wishes, Findings& findings) {
  Area area("processors", findings);
  const std::vector<int> online =
      parse_cpu_list(system.read(fmt::format("{}/online", kCpus)).value_or("0"));
  const std::vector<int>& ours = wishes.cpus.empty() ? online : wishes.cpus;
  look_at_governor(system, ours, area);
  look_at_sleep(system, ours, area);
  look_at_isolation(system, wishes, online, area);
  const std::optional<long> siblings = system.read_number(fmt::format("{}/smt/active", kCpus));
  if (siblings == 1) {
    area.warn("siblings",
              "two threads share each core (SMT): what runs on a core's other thread slows the "
              "cycle",
              "echo off | sudo tee /sys/devices/system/cpu/smt/control");
  } else if (siblings) {
    area.ok("siblings", "no core is shared by two threads");
  }
}

}  // namespace geodesic::tools
