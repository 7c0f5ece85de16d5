// The service thread: everything the daemon does that may take its time. It drains telemetry into
// log, trace and status, answers the control socket, watches the real-time thread, and is itself
// watched by the service manager, if there is one. If it hangs (a log nobody reads, a disk that is
// gone), the arm is not affected and signals still end the run.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <thread>

#include "rt/cyclic_thread.hpp"
#include "tools/geodesicd/control_socket.hpp"
#include "tools/geodesicd/daemon.hpp"
#include "tools/geodesicd/event_text.hpp"
#include "tools/geodesicd/log.hpp"
#include "tools/geodesicd/report.hpp"
#include "tools/geodesicd/requests.hpp"
#include "tools/geodesicd/service_manager.hpp"
#include "tools/geodesicd/standstill.hpp"
#include "tools/geodesicd/trace.hpp"

namespace geodesic::tools {

struct ServiceOptions {
  bool allow_zero_law = false;
  bool simulated_time = false;
};

class Service {
 public:
  /// All of them outlive the service. `trace` may be null.
  Service(const ServiceOptions& options, const Vocabulary& words, Daemon& daemon,
          const rt::CyclicThread& loop, ControlServer& socket, Log& log, Trace* trace);
  /// As stop().
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// @throws std::system_error if there is no thread to be had.
  void start();
  /// Drains what the real-time thread left and ends.
  void stop();

  /// The real-time thread stands still; the run's end has been asked for in vain. Any thread.
  bool stuck() const noexcept { return stuck_.load(std::memory_order_relaxed); }

  /// The run as far as it is known. Service thread, or any other after stop().
  RunView view() const;

 private:
  void run();
  void drain();
  void watch(std::chrono::milliseconds elapsed);
  void tell_drops();
  void trace_problem(const std::optional<std::string>& problem);

  ServiceOptions options_;
  const Vocabulary& words_;
  Daemon& daemon_;
  const rt::CyclicThread& loop_;
  ControlServer& socket_;
  Log& log_;
  Trace* trace_;
  RequestActions actions_;
  Standstill standstill_;
  ServiceManager manager_ = ServiceManager::current();
  Record last_;
  FaultList faults_;
  std::int64_t start_ns_ = 0;
  std::uint64_t drops_told_ = 0;
  std::atomic<bool> stop_{false};
  std::atomic<bool> stuck_{false};
  std::thread thread_;
};

}  // namespace geodesic::tools
