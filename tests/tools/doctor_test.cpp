// The doctor's findings, each against made-up /proc and /sys trees and interfaces.
#include <gtest/gtest.h>

#include <cerrno>
#include <map>

#include "tests/tools/geodesicd_fixture.hpp"
#include "tools/geodesic/doctor_looks.hpp"

namespace geodesic::tools::test {
namespace {

constexpr const char* kCpu = "/sys/devices/system/cpu/";

/// A machine made of files; begins as a good one.
struct Machine {
  Machine() {
    put("/proc/sys/kernel/osrelease", "6.12.0-rt5");
    put("/proc/version", "Linux version 6.12.0-rt5 #1 SMP PREEMPT_RT");
    put("/sys/kernel/realtime", "1");
    put("/proc/sys/kernel/sched_rt_runtime_us", "-1");
    put("/sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc");
    cpu("online", "0-3");
    cpu("isolated", "3");
    cpu("smt/active", "0");
    for (int i = 0; i < 4; ++i) {
      cpu("cpu" + std::to_string(i) + "/cpufreq/scaling_governor", "performance");
      state(i, 0, "POLL", 0, 0);
      state(i, 1, "C1", 2, 0);
    }
    put("/proc/self/status",
        "CapEff:\t0000000000804000\nCapBnd:\t000001ffffffffff\nNoNewPrivs:\t0");
    put("/proc/self/limits",
        "Max locked memory         8388608              8388608              bytes\n"
        "Max realtime priority     0                    0\n");
    put("/proc/self/uid_map", "         0          0 4294967295");
    wishes.cpus = {3};
  }
  void put(const std::string& path, const std::string& text) {
    const std::filesystem::path file = folder / path.substr(1);
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text << "\n";
  }
  void cpu(const std::string& name, const std::string& text) { put(kCpu + name, text); }
  void state(int cpu_number, int number, const char* name, int latency, int disabled) {
    const std::string place =
        "cpu" + std::to_string(cpu_number) + "/cpuidle/state" + std::to_string(number) + "/";
    cpu(place + "name", name);
    cpu(place + "latency", std::to_string(latency));
    cpu(place + "disable", std::to_string(disabled));
  }
  void remove(const std::string& path) { std::filesystem::remove_all(folder / path.substr(1)); }

  Findings look() {
    const SystemTree system(folder.path());
    Findings findings;
    look_at_kernel(system, findings);
    look_at_processors(system, wishes, findings);
    look_at_rights(system, wishes, findings);
    return findings;
  }

  TemporaryFolder folder;
  Wishes wishes;
};

const Finding* find(const Findings& findings, const std::string& what) {
  for (const Finding& finding : findings) {
    if (finding.what == what) return &finding;
  }
  return nullptr;
}

/// "GRADE: text | fix" of the finding about `what`.
std::string said(const Findings& findings, const std::string& what) {
  const Finding* found = find(findings, what);
  if (found == nullptr) return "nothing about " + what;
  // Whatever is not well comes with a command.
  EXPECT_EQ(found->grade == Grade::kOk, found->fix.empty()) << what;
  return std::string(to_string(found->grade)) + ": " + found->text + " | " + found->fix;
}

#define EXPECT_SAYS(findings, what, part) \
  EXPECT_NE(said(findings, what).find(part), std::string::npos) << said(findings, what)

TEST(Doctor, FindsNothingWrongWithAGoodMachine) {
  Machine machine;
  for (const Finding& finding : machine.look()) {
    EXPECT_EQ(finding.grade, Grade::kOk) << finding.what << ": " << finding.text;
  }
  EXPECT_GE(machine.look().size(), 9U);
}

TEST(Doctor, SurvivesAMachineThatTellsNothing) {
  const TemporaryFolder empty;
  const SystemTree system(empty.path());
  Findings findings;
  look_at_kernel(system, findings);
  look_at_processors(system, {}, findings);
  look_at_rights(system, {}, findings);
  EXPECT_SAYS(findings, "PREEMPT_RT", "WARN: unknown is not PREEMPT_RT");
  EXPECT_SAYS(findings, "priority", "BAD");
  EXPECT_SAYS(findings, "locked memory", "BAD");
}

TEST(Doctor, LooksAtTheKernel) {
  Machine machine;
  machine.remove("/sys/kernel/realtime");
  EXPECT_SAYS(machine.look(), "PREEMPT_RT", "OK");
  machine.put("/proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC");
  EXPECT_SAYS(machine.look(), "PREEMPT_RT", "sudo apt install linux-image-rt");
  machine.put("/proc/sys/kernel/sched_rt_runtime_us", "950000");
  EXPECT_SAYS(machine.look(), "run time", "OK: real-time threads may take 950000 of 1000000 us");
  machine.put("/proc/sys/kernel/sched_rt_runtime_us", "100000");
  EXPECT_SAYS(machine.look(), "run time", "WARN");
  machine.put("/proc/sys/kernel/sched_rt_runtime_us", "0");
  EXPECT_SAYS(machine.look(), "run time",
              "none can start | sudo sysctl -w kernel.sched_rt_runtime_us=950000");
  machine.put("/sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  EXPECT_SAYS(machine.look(), "clock", "WARN: hpet");
}

TEST(Doctor, LooksAtTheProcessors) {
  Machine machine;
  machine.cpu("cpu3/cpufreq/scaling_governor", "powersave");
  machine.cpu("cpu0/cpufreq/scaling_governor", "schedutil");  // not one of ours
  EXPECT_SAYS(machine.look(), "governor", "WARN: powersave on processor 3:");
  EXPECT_SAYS(machine.look(), "governor", "| echo performance | sudo tee");
  machine.wishes.cpus = {};
  EXPECT_SAYS(machine.look(), "governor", "on processor 0,3");
  EXPECT_SAYS(machine.look(), "isolation", "WARN: processor 3 is set aside, but");
  machine.cpu("isolated", "");
  EXPECT_SAYS(machine.look(), "isolation", "OK: no processor is set aside");
  machine.wishes.cpus = {2, 3};
  EXPECT_SAYS(machine.look(), "isolation", "processor 2,3 of [realtime] cpus is open to every");
  EXPECT_SAYS(machine.look(), "isolation", "isolcpus=2,3 nohz_full=2,3");
  machine.wishes.cpus = {3, 9};
  EXPECT_SAYS(machine.look(), "isolation", "BAD: [realtime] cpus names processor 9");
  machine.cpu("smt/active", "1");
  EXPECT_SAYS(machine.look(), "siblings", "echo off | sudo tee");
}

TEST(Doctor, LooksAtSleepStates) {
  Machine machine;
  machine.state(3, 2, "C6", 133, 0);
  EXPECT_SAYS(machine.look(), "sleep states", "WARN: C6 takes 133 us to wake");
  EXPECT_SAYS(machine.look(), "sleep states", "/etc/udev/rules.d/90-geodesic.rules");
  machine.put("/dev/cpu_dma_latency", "");
  EXPECT_SAYS(machine.look(), "sleep states", "OK: C6 takes 133 us to wake, but the daemon can");
  machine.remove("/dev/cpu_dma_latency");
  machine.state(3, 2, "C6", 133, 1);
  EXPECT_SAYS(machine.look(), "sleep states", "OK: the deepest, C1, wakes in 2 us");
}

TEST(Doctor, LooksAtRights) {
  Machine machine;
  machine.put("/proc/self/status", "CapEff:\t0\nCapBnd:\t000001ffffffffff\nNoNewPrivs:\t0");
  machine.wishes.program = "/usr/bin/geodesicd";
  EXPECT_SAYS(machine.look(), "priority", "limit of real-time priority 0");
  EXPECT_SAYS(machine.look(), "priority",
              "| sudo setcap cap_sys_nice,cap_ipc_lock+ep /usr/bin/geodesicd");
  EXPECT_SAYS(machine.look(), "locked memory", "BAD: at most 8192 KiB");
  machine.wishes.file_capabilities = true;
  EXPECT_SAYS(machine.look(), "priority", "OK: CAP_SYS_NICE");
  machine.put("/proc/self/status", "CapEff:\t0\nCapBnd:\t000001ffffffffff\nNoNewPrivs:\t1");
  EXPECT_SAYS(machine.look(), "priority", "NoNewPrivs makes the kernel ignore");
  machine.put("/proc/self/status", "CapEff:\t0\nCapBnd:\t0\nNoNewPrivs:\t0");
  EXPECT_SAYS(machine.look(), "priority", "the bounding set lacks");
  machine.put("/proc/self/limits",
              "Max locked memory         unlimited            unlimited            bytes\n"
              "Max realtime priority     99                   99\n");
  EXPECT_SAYS(machine.look(), "priority", "OK: limit 99 allows SCHED_FIFO 80");
  EXPECT_SAYS(machine.look(), "locked memory", "OK: without limit");
  machine.wishes.priority = 99;
  machine.put("/proc/self/limits", "Max realtime priority     98                   98\n");
  EXPECT_SAYS(machine.look(), "priority", "BAD: SCHED_FIFO 99");
  machine.wishes.bring_up = true;
  EXPECT_SAYS(machine.look(), "CAP_NET_ADMIN", "cap_net_admin+ep");
  machine.put("/proc/self/status", "CapEff:\t0000000000805000\nCapBnd:\t0");
  machine.put("/proc/self/uid_map", "0 1000 1");
  EXPECT_SAYS(machine.look(), "namespace", "WARN: in a user namespace of its own");
  EXPECT_SAYS(machine.look(), "priority", "BAD");
}

/// Interfaces as a test has them.
struct Links final : drivers::LinkPort {
  std::optional<drivers::CanLink> read(const std::string& name, int& error) override {
    error = ENODEV;
    const auto found = links.find(name);
    return found == links.end() ? std::nullopt : std::optional(found->second);
  }
  drivers::NetlinkVerdict change(int /*index*/, const drivers::LinkChange& /*change*/) override {
    ADD_FAILURE() << "the doctor changes nothing";
    return {};
  }
  std::map<std::string, drivers::CanLink> links;
};

struct Interface : Machine {
  Interface() {
    link.name = "can0";
    link.kind = "can";
    link.can = true;
    link.up = true;
    link.mtu = 16;
    link.queue = 64;
    link.nominal = {1'000'000, 0.75};
    link.restart_ms = 100;
    link.controller.emplace().state = drivers::ControllerState::kActive;
    bus.name = "arm";
    bus.interface = "can0";
  }
  Findings look() {
    Links port;
    if (there) port.links["can0"] = link;
    Findings findings;
    look_at_bus(SystemTree(folder.path()), port, bus, wishes, findings);
    for (const Finding& finding : findings) EXPECT_EQ(finding.area, "bus arm");
    return findings;
  }
  bool there = true;
  drivers::CanLink link;
  drivers::BusOptions bus;
};

TEST(Doctor, LooksAtAnInterface) {
  Interface can;
  for (const Finding& finding : can.look()) {
    EXPECT_EQ(finding.grade, Grade::kOk) << finding.what << ": " << finding.text;
  }
  EXPECT_SAYS(can.look(), "bit timing", "OK: 1000000 bit/s, sample point 0.750");
  can.link.nominal.bit_rate = 500'000;
  EXPECT_SAYS(can.look(), "bit timing", "BAD: bit rate 500000, configured 1000000 | sudo ip link");
  EXPECT_SAYS(can.look(), "bit timing", "bitrate 1000000");
  can.link.queue = 1;
  EXPECT_SAYS(can.look(), "queue", "| sudo ip link set can0 txqueuelen 64");
  can.link.restart_ms = 0;
  EXPECT_SAYS(can.look(), "restart", "restart-ms 100");
  can.link.up = false;
  EXPECT_SAYS(can.look(), "state", "BAD: down | sudo ip link set");
  can.link.can = false;
  EXPECT_SAYS(can.look(), "interface", "BAD: can0 is no CAN interface");
  can.there = false;
  EXPECT_SAYS(can.look(), "interface", "BAD: there is no can0: is the adapter plugged in");
  can.bus.interface = "vcan0";
  EXPECT_SAYS(can.look(), "interface", "sudo ip link add vcan0 type vcan");
  can.bus.interface = "usb:1-2";
  EXPECT_SAYS(can.look(), "interface", "BAD");
}

TEST(Doctor, LooksAtErrorCountersAndLosses) {
  Interface can;
  can.link.controller->receive_errors = 12;
  EXPECT_SAYS(can.look(), "controller", "OK: error-active, error counters 0 sending, 12 receiving");
  can.link.controller->bus_offs = 2;
  EXPECT_SAYS(can.look(), "controller", "WARN");
  can.link.controller->bus_offs = 0;
  can.link.controller->state = drivers::ControllerState::kWarning;
  EXPECT_SAYS(can.look(), "controller", "WARN: error-warning");
  can.link.controller->state = drivers::ControllerState::kPassive;
  EXPECT_SAYS(can.look(), "controller", "BAD: error-passive");
  can.link.controller->state = drivers::ControllerState::kBusOff;
  EXPECT_SAYS(can.look(), "controller", "termination of 120 ohm");
  EXPECT_SAYS(can.look(), "losses", "OK");
  can.put("/sys/class/net/can0/statistics/rx_dropped", "7");
  EXPECT_SAYS(can.look(), "losses", "WARN: rx_dropped 7");
}

TEST(Doctor, LooksAtTheInterruptsThread) {
  Interface can;
  EXPECT_EQ(find(can.look(), "interrupt"), nullptr);
  can.put("/sys/devices/pci0/card/irq", "42");
  std::filesystem::create_directories(can.folder / "sys/devices/pci0/card/usb1/net");
  std::filesystem::create_directories(can.folder / "sys/class/net/can0");
  std::filesystem::create_symlink("../../../devices/pci0/card/usb1",
                                  can.folder / "sys/class/net/can0/device");
  EXPECT_SAYS(can.look(), "interrupt", "OK: number 42, served at once");
  const auto thread = [&](const std::string& pid, const std::string& name, int priority,
                          int policy) {
    can.put("/proc/" + pid + "/comm", name);
    std::string stat = pid + " (" + name + ") S";
    for (int i = 4; i < 40; ++i) stat += " " + std::to_string(i);
    can.put("/proc/" + pid + "/stat",
            stat + " " + std::to_string(priority) + " " + std::to_string(policy) + " 0");
  };
  thread("71", "irq/421-other", 10, 1);
  EXPECT_SAYS(can.look(), "interrupt", "OK: number 42");
  thread("77", "irq/42-can (x)", 50, 1);
  EXPECT_SAYS(can.look(), "interrupt",
              "WARN: thread irq/42-can (x) at priority 50 is below the cycle's 80");
  EXPECT_SAYS(can.look(), "interrupt", "| sudo chrt --fifo --pid 85 77");
  thread("77", "irq/42-can (x)", 85, 0);
  EXPECT_SAYS(can.look(), "interrupt", "WARN");
  thread("77", "irq/42-can (x)", 85, 1);
  EXPECT_SAYS(can.look(), "interrupt", "OK: thread irq/42-can (x) at priority 85");
}

TEST(Doctor, ReadsSetsOfProcessors) {
  EXPECT_EQ(parse_cpu_list("0-2,5"), (std::vector<int>{0, 1, 2, 5}));
  EXPECT_EQ(parse_cpu_list(""), std::vector<int>{});
  EXPECT_EQ(parse_cpu_list("x,7"), std::vector<int>{7});
  EXPECT_EQ(parse_cpu_list("0-99999999").size(), 4097U);
  EXPECT_EQ(to_cpu_list({1, 3}), "1,3");
}

}  // namespace
}  // namespace geodesic::tools::test
