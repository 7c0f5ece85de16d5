// What is said when the kernel refuses: every cause gets its own words and its own fix. The facts
// are made up here; real refusals are in cyclic_thread_test.cpp.
#include "rt/privileges.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "rt/refusal.hpp"

namespace geodesic::rt {
namespace {

Privileges ordinary_user() {
  Privileges privileges;
  privileges.memlock_limit = std::uint64_t{8} << 20U;
  privileges.memory_bytes = std::uint64_t{100} << 20U;
  privileges.program = "/opt/arm/bin/loop";
  privileges.user = "ada";
  privileges.rt_runtime_us = 950'000;
  return privileges;
}

testing::AssertionResult says(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "\"" << part << "\" is not in:\n" << text;
}

TEST(Refusal, SchedulingAsAnOrdinaryUser) {
  const std::string text = to_string(explain_scheduling(ordinary_user(), "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "tried:   a thread \"loop\" with SCHED_FIFO at priority 80"));
  EXPECT_TRUE(says(text, "EPERM (1, Operation not permitted)"));
  EXPECT_TRUE(says(text, "CAP_SYS_NICE is not effective"));
  EXPECT_TRUE(says(text, "RLIMIT_RTPRIO is 0 where 80 is wanted"));
  EXPECT_TRUE(says(text, "sudo setcap cap_sys_nice,cap_ipc_lock+ep /opt/arm/bin/loop"));
  EXPECT_TRUE(says(text, "ada ada | sudo tee /etc/security/limits.d/90-geodesic.conf"));
  EXPECT_TRUE(says(text, "AmbientCapabilities=CAP_SYS_NICE CAP_IPC_LOCK"));
}

TEST(Refusal, PathIsQuotedForTheShell) {
  Privileges privileges = ordinary_user();
  privileges.program = "/home/ada/it's here/loop";
  const std::string text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "+ep '/home/ada/it'\\''s here/loop'"));
}

TEST(Refusal, CapabilityOfTheFileThatTookNoEffect) {
  Privileges privileges = ordinary_user();
  privileges.sys_nice.in_file = true;
  std::string text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "nosuid"));
  privileges.no_new_privileges = true;
  text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "NoNewPrivs is set"));
  EXPECT_FALSE(says(text, "sudo setcap"));
}

TEST(Refusal, Container) {
  Privileges privileges = ordinary_user();
  privileges.sys_nice.bounded_out = true;
  const std::string text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "bounding set"));
  EXPECT_TRUE(says(text, "--cap-add SYS_NICE --cap-add IPC_LOCK"));
  EXPECT_FALSE(says(text, "sudo setcap"));
}

TEST(Refusal, UserNamespace) {
  Privileges privileges = ordinary_user();
  privileges.sys_nice.effective = true;
  privileges.user_namespace = true;
  const std::string text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "user namespace"));
  EXPECT_TRUE(says(text, "prlimit --pid $$ --rtprio=99 --memlock=unlimited"));
}

TEST(Refusal, ControlGroupWithoutRunTime) {
  Privileges privileges = ordinary_user();
  privileges.sys_nice.effective = true;
  privileges.group_file = "/sys/fs/cgroup/cpu/arm/cpu.rt_runtime_us";
  privileges.group_runtime_us = 0;
  std::string text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "/sys/fs/cgroup/cpu/arm/cpu.rt_runtime_us is 0"));
  EXPECT_TRUE(says(text, "echo 950000 | sudo tee /sys/fs/cgroup/cpu/arm/cpu.rt_runtime_us"));
  // version 2 has no such file
  privileges.group_file.clear();
  privileges.group_runtime_us.reset();
  text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "CONFIG_RT_GROUP_SCHED"));
  EXPECT_TRUE(says(text, "kernel.sched_rt_runtime_us is 950000"));
  EXPECT_TRUE(says(text, "sudo sysctl -w kernel.sched_rt_runtime_us=-1"));
}

TEST(Refusal, PriorityAboveTheLimit) {
  Privileges privileges = ordinary_user();
  privileges.rtprio_limit = 50;
  const std::string text = to_string(explain_scheduling(privileges, "loop", 80, EPERM));
  EXPECT_TRUE(says(text, "RLIMIT_RTPRIO is 50 where 80 is wanted"));
}

TEST(Refusal, SystemCallFilter) {
  Privileges privileges = ordinary_user();
  privileges.sys_nice.effective = true;
  privileges.seccomp = true;
  EXPECT_TRUE(says(to_string(explain_scheduling(privileges, "loop", 80, EPERM)), "seccomp"));
}

TEST(Refusal, MemoryLock) {
  const std::string text = to_string(explain_memory_lock(ordinary_user(), ENOMEM));
  EXPECT_TRUE(says(text, "(mlockall MCL_CURRENT)"));
  EXPECT_TRUE(says(text, "ENOMEM (12, "));
  EXPECT_TRUE(says(text, "CAP_IPC_LOCK is not effective"));
  EXPECT_TRUE(says(text, "RLIMIT_MEMLOCK is 8192 KiB where this process has 102400 KiB"));
  EXPECT_TRUE(says(text, "sudo setcap cap_sys_nice,cap_ipc_lock+ep /opt/arm/bin/loop"));
  EXPECT_TRUE(says(text, "memlock unlimited"));
}

TEST(Refusal, MemoryLockWithoutEnoughMemory) {
  Privileges privileges = ordinary_user();
  privileges.ipc_lock.effective = true;
  EXPECT_TRUE(says(to_string(explain_memory_lock(privileges, ENOMEM)), "MemoryMax="));
}

TEST(Privileges, AreReadFromThisMachine) {
  const Privileges privileges = read_privileges();
  EXPECT_TRUE(privileges.program.starts_with('/')) << privileges.program;
  EXPECT_TRUE(says(privileges.program, "test_rt"));
  EXPECT_FALSE(privileges.user.empty());
  EXPECT_GT(privileges.memory_bytes, 0U);
  EXPECT_TRUE(privileges.rt_runtime_us.has_value());
  EXPECT_NE(usable_cpus(), "");
}

}  // namespace
}  // namespace geodesic::rt
