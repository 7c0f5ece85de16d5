// The service thread.
#include "tools/geodesicd/service.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>

#include <chrono>
#include <exception>
#include <utility>

namespace geodesic::tools {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kRound{10};
constexpr milliseconds kStandstill{1000};
// In simulated time a cycle lasts as long as the simulation takes to answer.
constexpr milliseconds kSimulatedStandstill{10000};
// A round may write a trace to a slow disk; a round that takes longer never ends.
constexpr milliseconds kEndsWithin{3000};

}  // namespace

Service::Service(const ServiceOptions& options, const Vocabulary& words, Daemon& daemon,
                 rt::CyclicThread& loop, ControlServer& socket, Log& log, Tuning& tuning,
                 BusKeeper& keeper, Trace* trace)
    : options_(options),
      words_(words),
      daemon_(daemon),
      loop_(loop),
      socket_(socket),
      log_(log),
      tuning_(tuning),
      keeper_(keeper),
      trace_(trace),
      standstill_(options.simulated_time ? kSimulatedStandstill : kStandstill) {
  actions_.status = [this] {
    nlohmann::ordered_json status = status_json(view());
    status["tuning"] = tuning_.status();
    return status;
  };
  actions_.tune = [this](const nlohmann::json& request) { return tuning_.answer(request); };
  actions_.hand_over = [this](const control::Request& request) { return daemon_.request(request); };
  actions_.exit = [this] { daemon_.lifetime().ask_exit(); };
  actions_.ending = [this] { return daemon_.lifetime().ending(); };
  actions_.allow_zero_law = options.allow_zero_law;
}

Service::~Service() {
  stop();
}

void Service::start(std::function<void()> greeting) {
  thread_ = std::thread([this, first = std::move(greeting)] { run(first); });
}

bool Service::stop() {
  if (!thread_.joinable()) {
    return true;
  }
  stop_.store(true, std::memory_order_relaxed);
  const Clock::time_point end = Clock::now() + kEndsWithin;
  while (!ended_.load(std::memory_order_acquire)) {
    if (Clock::now() > end) {
      return false;
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  thread_.join();
  try {
    drain();
    tell_buses();
    tell_signals();
    trace_problem(trace_ != nullptr ? trace_->flush() : std::nullopt);
  } catch (const std::exception& problem) {
    log_.critical(fmt::format("the end of the run is not told whole: {}", problem.what()));
  }
  return true;
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
          options_.simulated_time,
          loop_.not_sealed_reason(),
          keeper_.health()};
}

void Service::run(const std::function<void()>& greeting) noexcept {
  ::prctl(PR_SET_NAME, "geodesic-svc");
  try {
    greeting();
    serve();
  } catch (const std::exception& problem) {
    // Out of memory, most likely. Unwatched and deaf, the arm shall not go on for long.
    log_.critical(fmt::format("the service thread failed: {}; controlled stop", problem.what()));
    daemon_.lifetime().ask_exit();
  }
  ended_.store(true, std::memory_order_release);
}

void Service::serve() {
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
    tell_buses();
    tell_signals();
    const Clock::time_point now = Clock::now();
    tuning_.round(now, last_, static_cast<double>(last_.tick_ns - start_ns_) * 1e-9);
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
  tell_refused_calls();
  tell_drops();
}

void Service::tell_refused_calls() {
  rt::RefusedCall call;
  while (loop_.pop_refused_call(call)) {
    log_.error(fmt::format("the sealed real-time thread asked for {} at {}: not made",
                           rt::system_call_name(call.number),
                           rt::instruction_text(call.instruction)));
  }
}

void Service::tell_signals() {
  const int asked = asked_.load(std::memory_order_relaxed);
  for (; asked_told_ < asked; ++asked_told_) {
    if (asked_told_ == 0) {
      log_.info("asked to end: controlled stop");
    } else if (asked_told_ == 1) {
      log_.info("already stopping; once more takes torque off at once");
    } else {
      log_.warning("asked to end for the third time: torque off");
    }
  }
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

void Service::tell_buses() {
  for (const drivers::BusNews& news : keeper_.take_news()) {
    log_.write(news.warning ? Severity::kWarning : Severity::kInfo, news.text, {{"event", "bus"}});
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
