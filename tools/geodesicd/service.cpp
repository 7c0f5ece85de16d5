// The service thread.
#include "tools/geodesicd/service.hpp"

#include <fmt/format.h>

#include <chrono>

namespace geodesic::tools {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kRound{10};
constexpr milliseconds kStandstill{1000};
// In simulated time a cycle lasts as long as the simulation takes to answer.
constexpr milliseconds kSimulatedStandstill{10000};

}  // namespace

Service::Service(const ServiceOptions& options, const Vocabulary& words, Daemon& daemon,
                 const rt::CyclicThread& loop, ControlServer& socket, Log& log, Trace* trace)
    : options_(options),
      words_(words),
      daemon_(daemon),
      loop_(loop),
      socket_(socket),
      log_(log),
      trace_(trace),
      standstill_(options.simulated_time ? kSimulatedStandstill : kStandstill) {
  actions_.status = [this] { return status_json(view()); };
  actions_.hand_over = [this](const control::Request& request) { return daemon_.request(request); };
  actions_.exit = [this] { daemon_.lifetime().ask_exit(); };
  actions_.ending = [this] { return daemon_.lifetime().ending(); };
  actions_.allow_zero_law = options.allow_zero_law;
}

Service::~Service() {
  stop();
}

void Service::start() {
  thread_ = std::thread([this] { run(); });
}

void Service::stop() {
  if (!thread_.joinable()) {
    return;
  }
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
  drain();
  trace_problem(trace_ != nullptr ? trace_->flush() : std::nullopt);
}

RunView Service::view() const {
  const Telemetry& telemetry = daemon_.telemetry();
  return {words_,
          loop_.statistics(),
          daemon_.phases(),
          last_,
          telemetry.counters(),
          faults_,
          loop_.not_realtime_reason(),
          telemetry.records_dropped(),
          telemetry.events_dropped(),
          options_.simulated_time};
}

void Service::run() {
  const ControlServer::Handler answer = [this](std::string_view line) {
    log_.debug(fmt::format("request: {}", line));
    return answer_request(line, actions_);
  };
  Clock::time_point last_watch = Clock::now();
  bool stopping_told = false;
  manager_.ready("running");
  while (!stop_.load(std::memory_order_relaxed)) {
    socket_.serve(kRound, answer);
    drain();
    const Clock::time_point now = Clock::now();
    watch(std::chrono::duration_cast<milliseconds>(now - last_watch));
    last_watch = now;
    if (!stuck()) {
      manager_.alive(now);
    }
    if (daemon_.lifetime().ending() && !stopping_told) {
      stopping_told = true;
      manager_.stopping();
    }
  }
}

void Service::drain() {
  daemon_.telemetry().refresh();
  // A ring's worth at most: if the loop is faster than this thread, the socket still has its turn.
  for (int i = 0; i < 2048 && daemon_.telemetry().pop(last_); ++i) {
    if (start_ns_ == 0) {
      start_ns_ = last_.tick_ns;
    }
    if (trace_ != nullptr) {
      trace_problem(trace_->write(last_));
    }
  }
  Event event;
  while (daemon_.telemetry().pop(event)) {
    const EventText text = describe(event, words_, start_ns_);
    faults_.add(event, text);
    log_.write(text.severity, text.text, text.fields);
    if (event.kind == Event::Kind::kState) {
      manager_.status(control::to_string(event.to));
    }
  }
  tell_drops();
}

void Service::tell_drops() {
  const std::uint64_t drops = daemon_.telemetry().records_dropped();
  if (drops_told_ == 0 && drops > 0) {
    log_.warning(fmt::format(
        "the log and the trace are too slow for the loop: {} cycles so far are missing from the "
        "trace (the arm is not affected; the summary counts them all)",
        drops));
    drops_told_ = drops;
  }
}

void Service::watch(milliseconds elapsed) {
  if (!loop_.running() || !standstill_.update(loop_.statistics().cycles.load(), elapsed)) {
    return;
  }
  if (!stuck_.exchange(true)) {
    log_.critical(
        "the real-time thread stands still: no cycle for more than a second. The drives' own "
        "watchdogs have stopped them. Ending.");
    daemon_.lifetime().ask_exit();
  }
}

void Service::trace_problem(const std::optional<std::string>& problem) {
  if (problem) {
    log_.error(*problem);
  }
}

}  // namespace geodesic::tools
