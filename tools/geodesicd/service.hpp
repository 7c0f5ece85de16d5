// The service thread: everything the daemon does that may take its time. It drains telemetry into
// log, trace and status, answers the control socket, watches the real-time thread, and is itself
// watched by the service manager, if there is one. If it hangs (a log nobody reads, a disk that is
// gone) or dies, the arm is not affected and signals still end the run: nobody waits for it for
// ever.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "rt/cyclic_thread.hpp"
#include "tools/geodesicd/bus_keeper.hpp"
#include "tools/geodesicd/control_socket.hpp"
#include "tools/geodesicd/daemon.hpp"
#include "tools/geodesicd/event_text.hpp"
#include "tools/geodesicd/log.hpp"
#include "tools/geodesicd/report.hpp"
#include "tools/geodesicd/requests.hpp"
#include "tools/geodesicd/service_manager.hpp"
#include "tools/geodesicd/standstill.hpp"
#include "tools/geodesicd/trace.hpp"
#include "tools/geodesicd/tuning.hpp"

namespace geodesic::tools {

struct ServiceOptions {
  bool allow_zero_law = false;
  bool simulated_time = false;
};

class Service {
 public:
  /// All of them outlive the service. `trace` may be null.
  Service(const ServiceOptions& options, const Vocabulary& words, Daemon& daemon,
          rt::CyclicThread& loop, ControlServer& socket, Log& log, Tuning& tuning,
          BusKeeper& keeper, Trace* trace);
  /// As stop().
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// @param greeting  what the thread does first: words for the log, which may make it wait
  /// @throws std::system_error if there is no thread to be had.
  void start(std::function<void()> greeting);
  /// Drains what the real-time thread left and ends.
  /// @return false if the thread does not end: it hangs, nobody may wait for it, log by the same
  ///   log, or destroy this object.
  bool stop();

  /// A signal asked for the run's end, for the times'th time: the service thread tells it to the
  /// log, so that who takes signals never waits for a log's reader. Any thread.
  void asked_to_end(int times) noexcept { asked_.store(times, std::memory_order_relaxed); }

  /// The real-time thread stands still; the run's end has been asked for in vain. Any thread.
  bool stuck() const noexcept { return stuck_.load(std::memory_order_relaxed); }

  /// The run as far as it is known. Service thread, or any other after stop().
  RunView view() const;

 private:
  void run(const std::function<void()>& greeting) noexcept;
  void serve();
  void drain();
  void tell_refused_calls();
  void tell_signals();
  void watch(std::chrono::milliseconds elapsed);
  void tell_drops();
  void tell_buses();
  void trace_problem(const std::optional<std::string>& problem);

  ServiceOptions options_;
  const Vocabulary& words_;
  Daemon& daemon_;
  rt::CyclicThread& loop_;
  ControlServer& socket_;
  Log& log_;
  Tuning& tuning_;
  BusKeeper& keeper_;
  Trace* trace_;
  RequestActions actions_;
  Standstill standstill_;
  ServiceManager manager_ = ServiceManager::current();
  Record last_;
  FaultList faults_;
  std::int64_t start_ns_ = 0;
  std::uint64_t drops_told_ = 0;
  int asked_told_ = 0;
  std::atomic<int> asked_{0};
  std::atomic<bool> stop_{false};
  std::atomic<bool> ended_{false};
  std::atomic<bool> stuck_{false};
  std::thread thread_;
};

}  // namespace geodesic::tools
