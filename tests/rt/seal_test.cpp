// The seal on the real kernel: what a sealed thread asks for and may not have is not done, is told
// by name, and ends nothing.
#include "rt/seal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/sock_diag.h>
#include <poll.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "rt/capabilities.hpp"
#include "rt/clock.hpp"
#include "rt/cyclic_thread.hpp"
#include "tests/rt/child.hpp"

namespace geodesic::rt {
namespace {

class Steps : public Cyclic {
 public:
  Steps(int cycles, std::function<void(int)> work) : cycles_(cycles), work_(std::move(work)) {}
  Next step(const Tick& tick) noexcept override {
    told[static_cast<std::size_t>(made) % told.size()] = tick.refused_call;
    work_(made);
    return ++made < cycles_ ? Next::kContinue : Next::kStop;
  }
  std::array<int, 64> told{};
  int made = 0;

 private:
  int cycles_;
  std::function<void(int)> work_;
};

class SealTest : public testing::Test {  // NOLINT(cppcoreguidelines-virtual-class-destructor)
 protected:
  SealTest() {
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends_.data()),
              0);
    options_.name = "sealed";
    options_.best_effort = true;
    options_.seal = SealOptions{{ends_[0]}};
  }
  ~SealTest() override {
    close(ends_[0]);
    close(ends_[1]);
  }

  /// Runs `work` in a sealed loop of 5 cycles.
  /// @return names of the calls it was refused.
  std::vector<std::string> refused(const std::function<void(int)>& work) {
    Steps steps(5, work);
    CyclicThread thread(options_);
    const auto refusal = thread.start(steps);
    EXPECT_FALSE(refusal.has_value()) << to_string(*refusal);
    thread.join();
    EXPECT_EQ(steps.made, 5) << "a refused call ends nothing";
    EXPECT_EQ(thread.statistics().sealed, kSealBuilt);
    EXPECT_EQ(thread.statistics().sealed, thread.not_sealed_reason().empty());
    told_ = steps.told;
    std::vector<std::string> names;
    RefusedCall call;
    while (thread.pop_refused_call(call)) {
      names.push_back(system_call_name(call.number));
      where_ = instruction_text(call.instruction);
    }
    EXPECT_EQ(thread.statistics().refused_calls, names.size());
    return names;
  }

  std::array<int, 2> ends_{};
  ThreadOptions options_;
  std::array<int, 64> told_{};
  std::string where_;
};

TEST_F(SealTest, WhatTheLoopNeedsIsLetThrough) {
  std::array<bool, 5> done{};
  const auto names = refused([&](int cycle) {
    std::array<char, 8> bytes{};
    iovec vector{bytes.data(), bytes.size()};
    mmsghdr message{};
    message.msg_hdr.msg_iov = &vector;
    message.msg_hdr.msg_iovlen = 1;
    std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
    socklen_t size = sizeof(memory);
    pollfd waiting{ends_[0], POLLIN, 0};
    const timespec moment{0, 1000};
    timespec wall{};
    done[static_cast<std::size_t>(cycle)] =
        sendmmsg(ends_[0], &message, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1 &&
        recvmmsg(ends_[0], &message, 1, MSG_DONTWAIT, nullptr) == -1 && errno == EAGAIN &&
        ppoll(&waiting, 1, &moment, nullptr) == 0 &&
        getsockopt(ends_[0], SOL_SOCKET, SO_MEMINFO, memory.data(), &size) == 0 &&
        syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &wall) == 0 &&
        syscall(SYS_clock_gettime, CLOCK_REALTIME, &wall) == 0;
    sleep_until_ns(now_ns() + 1000);
  });
  EXPECT_EQ(done, (std::array<bool, 5>{true, true, true, true, true}));
  EXPECT_EQ(names, std::vector<std::string>{});
}

TEST_F(SealTest, AnythingElseIsNotDoneAndToldByName) {
  if (!kSealBuilt) return;  // a sanitizer's build has no seal, and says so: see refused()
  const std::string file = "/tmp/geodesic-sealed-" + std::to_string(getpid());
  std::array<int, 5> errors{};
  std::array<long, 5> results{};
  const auto names = refused([&](int cycle) {
    const auto i = static_cast<std::size_t>(cycle);
    errno = 0;
    if (cycle == 1) results[i] = open(file.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    if (cycle == 2) results[i] = syscall(SYS_getpid);
    if (cycle == 3) results[i] = kill(getppid(), 0);
    errors[i] = errno;
  });
  EXPECT_EQ(names, (std::vector<std::string>{"openat", "getpid", "getppid", "kill"}));
  EXPECT_EQ(errors, (std::array<int, 5>{0, ENOSYS, ENOSYS, ENOSYS, 0}));
  EXPECT_EQ(results, (std::array<long, 5>{0, -1, -1, -1, 0}));
  EXPECT_NE(access(file.c_str(), F_OK), 0) << "the call was made";
  EXPECT_NE(where_.find("+0x"), std::string::npos) << where_;
  // Each cycle hears of the one before it, of the first call if there were several.
  EXPECT_EQ(told_[1], 0);
  EXPECT_EQ(told_[2], SYS_openat + 1);
  EXPECT_EQ(told_[3], SYS_getpid + 1);
  EXPECT_EQ(told_[4], SYS_getppid + 1);
}

TEST_F(SealTest, ArgumentsCountToo) {
  if (!kSealBuilt) return;
  const auto names = refused([&](int cycle) {
    if (cycle != 1) return;
    std::array<char, 8> bytes{};
    iovec vector{bytes.data(), bytes.size()};
    mmsghdr message{};
    message.msg_hdr.msg_iov = &vector;
    message.msg_hdr.msg_iovlen = 1;
    timespec moment{0, 0};
    int value = 0;
    socklen_t size = sizeof(value);
    std::array<pollfd, 2> waiting{pollfd{ends_[0], POLLIN, 0}, pollfd{ends_[1], POLLIN, 0}};
    sendmmsg(ends_[0], &message, 1, 0);                      // would wait for room
    sendmmsg(ends_[1], &message, 1, MSG_DONTWAIT);           // not a bus
    recvmmsg(ends_[0], &message, 1, 0, nullptr);             // would wait
    recvmmsg(ends_[0], &message, 1, MSG_DONTWAIT, &moment);  // would wait, with a limit
    recvmmsg(ends_[1], &message, 1, MSG_DONTWAIT, nullptr);  // not a bus
    getsockopt(ends_[0], SOL_SOCKET, SO_ERROR, &value, &size);
    ppoll(waiting.data(), 2, &moment, nullptr);                        // more than there are buses
    clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &moment, nullptr);  // a clock that may step
    syscall(SYS_clock_gettime, CLOCK_BOOTTIME, &moment);
  });
  EXPECT_EQ(names,
            (std::vector<std::string>{"sendmmsg", "sendmmsg", "recvmmsg", "recvmmsg", "recvmmsg",
                                      "getsockopt", "ppoll", "clock_nanosleep", "clock_gettime"}));
}

TEST_F(SealTest, MoreRefusalsThanAreKeptAreCounted) {
  if (!kSealBuilt) return;
  Steps steps(2, [](int cycle) {
    for (int i = 0; cycle == 0 && i < 100; ++i) syscall(SYS_getpid);
  });
  CyclicThread thread(options_);
  ASSERT_FALSE(thread.start(steps).has_value());
  thread.join();
  EXPECT_EQ(thread.statistics().refused_calls, 100U);
  EXPECT_EQ(thread.statistics().allocations, 0U);
}

TEST_F(SealTest, OtherThreadsAreNotSealed) {
  Steps steps(1'000'000, [](int) {});
  CyclicThread thread(options_);
  steps.made = 1'000'000 - 20;
  ASSERT_FALSE(thread.start(steps).has_value());
  EXPECT_GT(syscall(SYS_getpid), 0);
  std::thread([] { EXPECT_GT(syscall(SYS_getpid), 0); }).join();
  thread.join();
  EXPECT_EQ(thread.statistics().refused_calls, 0U);
}

TEST_F(SealTest, ThreadsComeAndGo) {
  // A sealed thread ends by a call of its own; what it leaves must serve the next one.
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE(refused([](int) {}).empty());
  }
}

TEST(Seal, WithoutItEverythingIsAllowed) {
  ThreadOptions options;
  options.best_effort = true;
  Steps steps(3, [](int) { syscall(SYS_getpid); });
  CyclicThread thread(options);
  ASSERT_FALSE(thread.start(steps).has_value());
  thread.join();
  EXPECT_FALSE(thread.statistics().sealed);
  EXPECT_EQ(thread.not_sealed_reason(), "not asked for");
  EXPECT_EQ(thread.statistics().refused_calls, 0U);
}

TEST(Seal, RefusedWhereAnotherFilterForbidsIt) {
  if (!kSealBuilt) return;
  const std::string result = test::in_child([] {
    // As a container does.
    const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
    seccomp_rule_add(filter, SCMP_ACT_ERRNO(EPERM), SCMP_SYS(seccomp), 0);
    if (seccomp_load(filter) != 0) return std::string("no filter");
    seccomp_release(filter);
    std::string text;
    for (const bool best_effort : {false, true}) {
      ThreadOptions options;
      options.simulated_time = true;
      options.best_effort = best_effort;
      options.seal = SealOptions{{0}};
      Steps steps(3, [](int) {});
      CyclicThread thread(options);
      const auto refusal = thread.start(steps);
      thread.join();
      text += std::to_string(steps.made) + (thread.statistics().sealed ? " sealed " : " open ");
      const std::string why = refusal ? to_string(*refusal) : thread.not_sealed_reason();
      text += why.find("forbids the call seccomp") != std::string::npos ? "told; " : why;
    }
    return text;
  });
  EXPECT_EQ(result, "0 open told; 3 open told; ");
}

TEST(Seal, SomebodyElsesFilterStillEndsTheProcess) {
  if (!kSealBuilt) return;
  EXPECT_EXIT(
      {
        Seal seal;
        if (seal.prepare({{0}})) std::_Exit(1);
        raise(SIGSYS);  // on a thread that has no seal
        std::_Exit(2);
      },
      testing::KilledBySignal(SIGSYS), "");
}

TEST(Seal, RefusalsSayWhatIsMissing) {
  EXPECT_NE(to_string(explain_seal(EINVAL)).find("CONFIG_SECCOMP_FILTER"), std::string::npos);
  EXPECT_NE(to_string(explain_seal(EPERM)).find("SystemCallFilter"), std::string::npos);
  EXPECT_NE(to_string(explain_seal(ENOSYS)).find("--no-seal"), std::string::npos);
  EXPECT_EQ(system_call_name(SYS_openat), "openat");
  EXPECT_EQ(system_call_name(9999), "number 9999");
}

TEST(Capabilities, NothingIsLeftOnceTheLoopRuns) {
  const std::string result = test::in_child([] {
    const std::string given_up = keep_realtime_capabilities();
    const std::string between = capabilities_left();
    ThreadOptions options;
    options.best_effort = true;
    options.drop_capabilities = true;
    Steps steps(1'000'000, [](int) {});
    CyclicThread thread(options);
    if (const auto refusal = thread.start(steps)) return to_string(*refusal);
    drop_thread_capabilities();
    const std::string left = capabilities_left();
    // Memory can still be had though it is locked, by the heap and by new mappings.
    std::vector<char> heap(std::size_t{64} << 20U, 1);
    void* const mapped = mmap(nullptr, std::size_t{64} << 20U, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    thread.request_stop();
    thread.join();
    std::string text = mapped == MAP_FAILED ? "no memory left; " : "";
    if (geteuid() == 0 && given_up.find("cap_net_raw") == std::string::npos) {
      text += "given up at once: " + given_up + "; ";
    }
    if (between.find("CapPrm 0000000000804000") == std::string::npos && geteuid() == 0) {
      text += "kept: " + between + "; ";
    }
    return text + (kSealBuilt ? left : "");  // a sanitizer has threads of its own
  });
  EXPECT_EQ(result, "");
}

}  // namespace
}  // namespace geodesic::rt
