// The filter by libseccomp, and the signal by which the kernel tells of a refused call.
#include "rt/seal.hpp"

#include <dlfcn.h>
#include <linux/seccomp.h>
#include <linux/sock_diag.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <sstream>
#include <string_view>
#include <type_traits>

namespace geodesic::rt {
namespace {

struct ReleaseFilter {
  void operator()(void* filter) const { seccomp_release(filter); }
};
using Filter = std::unique_ptr<void, ReleaseFilter>;

/// The seal of this thread; null while it has none. Read by the signal handler: it must not be
/// reached by a call that allocates, so the program itself holds it and no shared library.
thread_local Seal* this_threads_seal = nullptr;

struct sigaction handler_before {};

scmp_arg_cmp equals(unsigned argument, std::uint64_t value) {
  return {argument, SCMP_CMP_EQ, value, 0};
}

/// Arguments that are an int to the kernel: what is above its 32 bits does not count.
scmp_arg_cmp equals_int(unsigned argument, unsigned value, unsigned without = 0) {
  return {argument, SCMP_CMP_MASKED_EQ, UINT32_MAX & ~without, value};
}

scmp_arg_cmp at_most(unsigned argument, std::uint64_t value) {
  return {argument, SCMP_CMP_LE, value, 0};
}

class Rules {
 public:
  explicit Rules(void* filter) : filter_(filter) {}

  void allow(int call, const std::vector<scmp_arg_cmp>& arguments = {}) {
    const int result = seccomp_rule_add_array(filter_, SCMP_ACT_ALLOW, call,
                                              static_cast<unsigned>(arguments.size()),
                                              arguments.empty() ? nullptr : arguments.data());
    error_ = error_ == 0 ? -result : error_;
  }

  /// Earlier ones are found faster.
  void order(std::initializer_list<int> calls) {
    std::uint8_t priority = UINT8_MAX;
    for (const int call : calls) seccomp_syscall_priority(filter_, call, priority--);
  }

  int error() const { return error_; }

 private:
  void* filter_;
  int error_ = 0;
};

/// Everything a sealed thread may ask of the kernel. README.md has the same list.
int add_rules(void* filter, const SealOptions& options) {
  Rules rules(filter);
  rules.order({SCMP_SYS(clock_gettime), SCMP_SYS(ppoll), SCMP_SYS(recvmmsg), SCMP_SYS(sendmmsg),
               SCMP_SYS(clock_nanosleep), SCMP_SYS(getsockopt)});
  // Sleep: until an instant of the one clock, or until a bus has something, signals as they are.
  rules.allow(SCMP_SYS(clock_nanosleep),
              {equals_int(0, CLOCK_MONOTONIC), equals_int(1, TIMER_ABSTIME)});
  rules.allow(SCMP_SYS(ppoll), {at_most(1, options.descriptors.size()), equals(3, 0)});
  // Clock: a call only where the kernel has no vDSO for it.
  rules.allow(SCMP_SYS(clock_gettime), {equals_int(0, CLOCK_MONOTONIC)});
  rules.allow(SCMP_SYS(clock_gettime), {equals_int(0, CLOCK_REALTIME)});
  for (const int descriptor : options.descriptors) {
    const auto own = equals_int(0, static_cast<unsigned>(descriptor));
    // Send and receive: on the buses only, and never waiting.
    rules.allow(SCMP_SYS(sendmmsg), {own, equals_int(3, MSG_DONTWAIT, MSG_NOSIGNAL)});
    rules.allow(SCMP_SYS(recvmmsg), {own, equals_int(3, MSG_DONTWAIT), equals(4, 0)});
    // How much of what was sent still waits.
    rules.allow(SCMP_SYS(getsockopt), {own, equals_int(1, SOL_SOCKET), equals_int(2, SO_MEMINFO)});
  }
  // Exit: the thread's, and back from the handler of a refused call.
  rules.allow(SCMP_SYS(exit));
  rules.allow(SCMP_SYS(rt_sigreturn));
  return rules.error();
}

int export_program(void* filter, std::vector<sock_filter>& program) {
  const int file = memfd_create("seal", MFD_CLOEXEC);
  if (file < 0) return errno;
  int error = -seccomp_export_bpf(filter, file);
  if (error == 0) {
    const off_t bytes = lseek(file, 0, SEEK_END);
    program.resize(static_cast<std::size_t>(bytes) / sizeof(sock_filter));
    if (pread(file, program.data(), static_cast<std::size_t>(bytes), 0) != bytes) error = EIO;
  }
  close(file);
  return error;
}

int compile(const SealOptions& options, std::vector<sock_filter>& program) {
  const Filter filter(seccomp_init(SCMP_ACT_TRAP));
  if (!filter) return ENOMEM;
  // Calls by the door of another architecture are told of too, and kill no more than any other.
  if (const int error = seccomp_attr_set(filter.get(), SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_TRAP);
      error != 0) {
    return -error;
  }
  if (const int error = add_rules(filter.get(), options); error != 0) return error;
  return export_program(filter.get(), program);
}

/// Makes the interrupted call return ENOSYS. @return the instruction it comes back to.
std::uintptr_t fail_call(void* context) noexcept {
  auto& machine = static_cast<ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  machine.gregs[REG_RAX] = -ENOSYS;
  return static_cast<std::uintptr_t>(machine.gregs[REG_RIP]);
#elif defined(__aarch64__)
  machine.regs[0] = static_cast<decltype(machine.regs[0] + 0)>(-ENOSYS);
  return static_cast<std::uintptr_t>(machine.pc);
#else
#error "which register holds a system call's result on this architecture?"
#endif
}

}  // namespace

/// The handler of SIGSYS. Async-signal-safe: it writes to the interrupted thread's own seal only.
struct SealSignal {
  static void hear(int signal, siginfo_t* info, void* context) {
    if (this_threads_seal == nullptr) {
      // Somebody else's filter: as if we were not here.
      sigaction(signal, &handler_before, nullptr);
      std::raise(signal);
      return;
    }
    this_threads_seal->note(info->si_syscall, fail_call(context));
  }
};

std::optional<Refusal> Seal::prepare(const SealOptions& options) {
  if (const int error = compile(options, program_); error != 0) return explain_seal(error);
  struct sigaction action {};
  action.sa_sigaction = &SealSignal::hear;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigfillset(&action.sa_mask);
  sigdelset(&action.sa_mask, SIGSEGV);
  struct sigaction before {};
  if (sigaction(SIGSYS, &action, &before) != 0) return explain_seal(errno);
  if (before.sa_sigaction != &SealSignal::hear) handler_before = before;
  return std::nullopt;
}

int Seal::apply() noexcept {
  sigset_t own;
  sigemptyset(&own);
  sigaddset(&own, SIGSYS);
  pthread_sigmask(SIG_UNBLOCK, &own, nullptr);
  if (prctl(PR_SET_NO_NEW_PRIVS, 1UL, 0UL, 0UL, 0UL) != 0) return errno;
  this_threads_seal = this;
  sock_fprog program{};
  program.len = static_cast<unsigned short>(program_.size());
  program.filter = program_.data();
  // Older kernels slow down whoever has a filter, against code that spies on its own process by
  // speculation. There is none here: the flag asks for full speed, where it is known.
  long result =
      syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_SPEC_ALLOW, &program);
  if (result != 0 && errno == EINVAL) {
    result = syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program);
  }
  if (result != 0) {
    this_threads_seal = nullptr;
    return errno;
  }
  // It holds: a call that always succeeds must not.
  const bool holds = syscall(SYS_getppid) == -1 && errno == ENOSYS && refused() == 1;
  RefusedCall proof;
  pop(proof);
  take();
  refused_.store(0, std::memory_order_relaxed);
  return holds ? 0 : ENOSYS;
}

int Seal::take() noexcept {
  const int first = pending_.load(std::memory_order_relaxed);
  if (first != 0) pending_.store(0, std::memory_order_relaxed);
  return first;
}

void Seal::note(int number, std::uintptr_t instruction) noexcept {
  refused_.store(refused_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  if (pending_.load(std::memory_order_relaxed) == 0) {
    pending_.store(number + 1, std::memory_order_relaxed);
  }
  calls_.push({number, instruction});
}

Refusal explain_seal(int error_number) {
  Refusal refusal;
  refusal.attempted = "to seal the real-time thread against system calls (seccomp)";
  refusal.error_number = error_number;
  if (error_number == EPERM || error_number == EACCES) {
    refusal.missing =
        "a system call filter that is in force already, as in a container or a "
        "restricted unit, forbids the call seccomp";
    refusal.fix =
        "under systemd: @sandbox in SystemCallFilter=\n"
        "in a container: --security-opt seccomp=PROFILE, of which the default allows it";
  } else {
    refusal.missing = "this kernel has no system call filters (CONFIG_SECCOMP_FILTER)";
    refusal.fix = "a kernel with CONFIG_SECCOMP_FILTER=y, as distributions build it";
  }
  refusal.fix += "\ngo on unsealed: --no-seal, or --best-effort";
  return refusal;
}

std::string system_call_name(int number) {
  const std::unique_ptr<char, decltype(&std::free)> name(
      seccomp_syscall_resolve_num_arch(SCMP_ARCH_NATIVE, number), &std::free);
  return name ? std::string(name.get()) : "number " + std::to_string(number);
}

std::string instruction_text(std::uintptr_t instruction) {
  Dl_info found{};
  std::ostringstream text;
  const void* address = nullptr;
  static_assert(sizeof(address) == sizeof(instruction));
  std::memcpy(&address, &instruction, sizeof(address));
  std::uintptr_t base = 0;
  if (dladdr(address, &found) != 0 && found.dli_fname != nullptr) {
    const std::string_view file = found.dli_fname;
    std::memcpy(&base, &found.dli_fbase, sizeof(base));
    text << file.substr(file.rfind('/') + 1) << '+';
  }
  text << "0x" << std::hex << instruction - base;
  return text.str();
}

void exit_thread() noexcept {
  while (true) syscall(SYS_exit, 0);
}

}  // namespace geodesic::rt
