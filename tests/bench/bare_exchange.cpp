// Two minimal programs that exchange a cycle of CAN frames and do nothing else: the least that an
// exchange costs on a machine, which the daemon's is measured against. No drives, no control.
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/bare_bus.hpp"
#include "tests/bench/bare_options.hpp"

namespace geodesic::bench {
namespace {

volatile std::sig_atomic_t stop_asked = 0;

using Buses = std::vector<std::unique_ptr<BareBus>>;

Buses open_buses(const BareOptions& options, const std::vector<std::uint32_t>& let_in) {
  Buses buses;
  for (const std::string& name : options.buses) {
    buses.push_back(open_bare_bus(name, {options.extended, options.fd, let_in}));
  }
  return buses;
}

void fill(canfd_frame& frame, std::uint32_t id, const BareOptions& options) noexcept {
  frame.can_id = options.extended ? id | CAN_EFF_FLAG : id;
  frame.len = options.length;
  frame.flags = options.fd ? CANFD_BRS | CANFD_FDF : 0;
}

std::size_t index_of(const std::vector<std::uint32_t>& ids, std::uint32_t id) noexcept {
  return static_cast<std::size_t>(std::find(ids.begin(), ids.end(), id) - ids.begin());
}

/// What the scheduler and the memory manager granted.
struct Granted {
  bool fifo = false;
  bool locked = false;
};

Granted become_real_time(const BareOptions& options) {
  Granted granted;
  if (options.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(options.cpu), &set);
    if (::sched_setaffinity(0, sizeof set, &set) != 0) {
      fail("--cpu %d: %s", options.cpu, std::strerror(errno));
    }
  }
  granted.locked = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (options.priority > 0) {
    const sched_param parameter{.sched_priority = options.priority};
    granted.fifo = ::sched_setscheduler(0, SCHED_FIFO, &parameter) == 0;
  }
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  return granted;
}

int respond(const BareOptions& options) {
  const Buses buses = open_buses(options, options.ids);
  become_real_time(options);
  std::vector<pollfd> waits;
  for (const auto& bus : buses) {
    waits.push_back({.fd = bus->socket, .events = POLLIN, .revents = 0});
  }
  while (stop_asked == 0) {
    if (::ppoll(waits.data(), waits.size(), nullptr, nullptr) <= 0) {
      continue;
    }
    for (std::size_t b = 0; b < buses.size(); ++b) {
      if (waits[b].revents == 0) {
        continue;
      }
      BareBus& bus = *buses[b];
      const std::size_t n = read_batch(bus);
      std::size_t replies = 0;
      for (std::size_t i = 0; i < n && replies < kMaxFrames; ++i) {
        const std::size_t which = index_of(options.ids, bus.in[i].can_id);
        if (which < options.ids.size()) {
          fill(bus.out[replies], options.reply_ids[which], options);
          std::memcpy(bus.out[replies].data, bus.in[i].data, options.length);
          ++replies;
        }
      }
      const std::size_t step = options.reply_gap_ns > 0 ? 1 : replies;
      for (std::size_t i = 0; i < replies; i += step) {
        send_batch(bus, i, step);
        if (options.reply_gap_ns > 0) {
          const timespec gap = to_timespec(options.reply_gap_ns);
          ::clock_nanosleep(CLOCK_MONOTONIC, 0, &gap, nullptr);
        }
      }
    }
  }
  return 0;
}

struct Figures {
  Granted granted;
  std::vector<std::int64_t> wake_ns;      ///< due -> running
  std::vector<std::int64_t> send_ns;      ///< all frames handed to the kernel
  std::vector<std::int64_t> exchange_ns;  ///< first send -> last reply read; complete cycles only
  std::int64_t incomplete = 0;  ///< cycles in which a reply did not come within the budget
  std::int64_t skipped = 0;     ///< periods that were over before their turn came
  std::int64_t refused = 0;     ///< batches the kernel did not take
};

/// Waits until every bus has given every reply of this cycle. @return false at the deadline.
bool collect(const Buses& buses, std::vector<pollfd>& waits, const BareOptions& options,
             std::uint32_t sequence, std::int64_t deadline) noexcept {
  std::size_t owed = buses.size() * options.ids.size();
  while (owed > 0) {
    const std::int64_t left = deadline - now_ns();
    const timespec timeout = to_timespec(std::max<std::int64_t>(left, 0));
    const int ready = ::ppoll(waits.data(), waits.size(), &timeout, nullptr);
    if (ready == 0 || stop_asked != 0) {
      return false;
    }
    for (std::size_t b = 0; b < buses.size(); ++b) {
      if (ready < 0 || waits[b].revents == 0) {
        continue;
      }
      BareBus& bus = *buses[b];
      const std::size_t n = read_batch(bus);
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t which = index_of(options.reply_ids, bus.in[i].can_id);
        const std::uint64_t bit = which < kMaxFrames ? std::uint64_t{1} << which : 0;
        const std::size_t marked = std::min<std::size_t>(options.length, sizeof sequence);
        if (which < options.ids.size() && (bus.heard & bit) == 0 &&
            std::memcmp(bus.in[i].data, &sequence, marked) == 0) {
          bus.heard |= bit;
          --owed;
        }
      }
    }
  }
  return true;
}

Figures command(const BareOptions& options) {
  const Buses buses = open_buses(options, options.reply_ids);
  Figures figures;
  figures.granted = become_real_time(options);
  std::vector<pollfd> waits;
  for (const auto& bus : buses) {
    waits.push_back({.fd = bus->socket, .events = POLLIN, .revents = 0});
    for (std::size_t i = 0; i < options.ids.size(); ++i) {
      fill(bus->out[i], options.ids[i], options);
    }
  }
  for (auto* samples : {&figures.wake_ns, &figures.send_ns, &figures.exchange_ns}) {
    samples->reserve(static_cast<std::size_t>(options.cycles));
  }
  const auto budget =
      static_cast<std::int64_t>(options.budget * static_cast<double>(options.period_ns));
  std::int64_t due = now_ns() + options.period_ns;
  const std::int64_t give_up = due + 10 * kSecond;
  bool answered = false;
  std::uint32_t sequence = 0;
  for (std::int64_t cycle = -options.warm_up; cycle < options.cycles && stop_asked == 0; ++cycle) {
    const timespec wake_up = to_timespec(due);
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake_up, nullptr);
    const std::int64_t woke = now_ns();
    ++sequence;
    bool taken = true;
    for (const auto& bus : buses) {
      bus->heard = 0;
      for (std::size_t i = 0; i < options.ids.size(); ++i) {
        std::memcpy(bus->out[i].data, &sequence,
                    std::min<std::size_t>(options.length, sizeof sequence));
      }
      taken = send_batch(*bus, 0, options.ids.size()) && taken;
    }
    const std::int64_t sent = now_ns();
    const bool complete = collect(buses, waits, options, sequence, due + budget);
    const std::int64_t done = now_ns();
    std::int64_t skipped = 0;
    for (due += options.period_ns; due <= done; due += options.period_ns) {
      ++skipped;
    }
    answered = answered || complete;
    if (!answered) {  // the responder is still starting
      if (now_ns() > give_up) {
        fail("nobody answered for 10 s; start a responder with the same options first");
      }
      cycle = -options.warm_up - 1;
    }
    if (cycle < 0) {
      continue;
    }
    figures.wake_ns.push_back(woke - (due - (skipped + 1) * options.period_ns));
    figures.send_ns.push_back(sent - woke);
    figures.refused += taken ? 0 : 1;
    figures.skipped += skipped;
    figures.incomplete += complete ? 0 : 1;
    if (complete) {
      figures.exchange_ns.push_back(done - woke);
    }
  }
  return figures;
}

struct Share {
  const char* name;
  double share;
};
constexpr std::array<Share, 6> kShares{
    {{"min", 0.0}, {"p50", 0.5}, {"p90", 0.9}, {"p99", 0.99}, {"p999", 0.999}, {"max", 1.0}}};

void print_distribution(const char* name, std::vector<std::int64_t> samples, bool json) {
  std::sort(samples.begin(), samples.end());
  std::printf(json ? ", \"%s\": {" : "  %-12s", name);
  for (const Share& share : kShares) {
    const std::size_t last = samples.empty() ? 0 : samples.size() - 1;
    const auto index = static_cast<std::size_t>(share.share * static_cast<double>(last));
    const std::int64_t value = samples.empty() ? 0 : samples[index];
    if (json) {
      std::printf("%s\"%s\": %lld", &share == kShares.data() ? "" : ", ", share.name,
                  static_cast<long long>(value));
    } else {
      std::printf(" %9.1f", static_cast<double>(value) * 1e-3);
    }
  }
  std::fputs(json ? "}" : "\n", stdout);
}

void print(const BareOptions& options, const Figures& figures) {
  const auto count = [](std::int64_t n) { return static_cast<long long>(n); };
  const auto cycles = static_cast<std::int64_t>(figures.wake_ns.size());
  if (options.json) {
    std::printf(
        "{\"buses\": %zu, \"frames\": %zu, \"length\": %d, \"fd\": %s, \"period_ns\": %lld, "
        "\"cycles\": %lld, \"incomplete\": %lld, \"skipped\": %lld, \"refused\": %lld, "
        "\"fifo\": %s, \"memory_locked\": %s",
        options.buses.size(), options.ids.size(), options.length, options.fd ? "true" : "false",
        count(options.period_ns), count(cycles), count(figures.incomplete), count(figures.skipped),
        count(figures.refused), figures.granted.fifo ? "true" : "false",
        figures.granted.locked ? "true" : "false");
  } else {
    std::printf(
        "bare exchange: %zu x %zu frames of %d bytes%s and their replies, %lld cycles%s%s\n",
        options.buses.size(), options.ids.size(), options.length, options.fd ? " (FD)" : "",
        count(cycles), figures.granted.fifo ? ", SCHED_FIFO" : ", SCHED_FIFO not granted",
        figures.granted.locked ? "" : ", memory not locked");
    std::printf("  %lld incomplete, %lld periods skipped, %lld batches refused\n  us          ",
                count(figures.incomplete), count(figures.skipped), count(figures.refused));
    for (const Share& share : kShares) {
      std::printf(" %9s", share.name);
    }
    std::fputc('\n', stdout);
  }
  print_distribution(options.json ? "wake_ns" : "wake-up", figures.wake_ns, options.json);
  print_distribution(options.json ? "send_ns" : "sends", figures.send_ns, options.json);
  print_distribution(options.json ? "exchange_ns" : "exchange", figures.exchange_ns, options.json);
  std::fputs(options.json ? "}\n" : "", stdout);
}

/// The responder as a process of its own, which ends with the commander.
int run_pair(const BareOptions& options) {
  std::fflush(stdout);
  const pid_t responder = ::fork();
  if (responder < 0) {
    fail("cannot start a second process: %s", std::strerror(errno));
  }
  if (responder == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    std::_Exit(respond(options));
  }
  print(options, command(options));
  ::kill(responder, SIGTERM);
  ::waitpid(responder, nullptr, 0);
  return 0;
}

}  // namespace
}  // namespace geodesic::bench

int main(int argc, char** argv) {
  using namespace geodesic::bench;
  const BareOptions options = parse_bare_options(argc, argv);
  struct sigaction action {};
  action.sa_handler = [](int) { stop_asked = 1; };  // no SA_RESTART: waiting ends
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
  if (options.role == "responder") {
    return respond(options);
  }
  if (options.role == "pair") {
    return run_pair(options);
  }
  print(options, command(options));
  return 0;
}
