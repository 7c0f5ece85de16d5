// Tuning while it runs, as the service thread does it: watches the files, answers operators, waits
// for the real-time thread's word, and says in log and status what became of it. What is taken and
// what is refused is decided in tuner.hpp.
#pragma once

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/geodesicd/file_watch.hpp"
#include "tools/geodesicd/log.hpp"
#include "tools/geodesicd/setup_exchange.hpp"
#include "tools/geodesicd/tuner.hpp"

namespace geodesic::tools {

class Tuning {
 public:
  using Clock = std::chrono::steady_clock;

  /// `exchange` and `log` outlive it. @param start  what the daemon started with
  /// @param compiled  as Tuner's; outlives it
  Tuning(const CommandLine& line, const config::LoadResult& start, SetupExchange& exchange,
         Log& log, const compile::VerifiedModel* compiled = nullptr);

  /// Has the files read again at the next round. Any thread.
  void ask_reload() noexcept { reload_asked_.store(true, std::memory_order_relaxed); }

  /// Service thread, often. `last`: the newest cycle; `at_s`: its time since the first.
  void round(Clock::time_point now, const Record& last, double at_s);

  /// {"cmd":"tune", ...}, see requests.hpp. Service thread.
  nlohmann::ordered_json answer(const nlohmann::json& request);

  /// What is tuned, and what became of the last attempt. Service thread, or once it has ended.
  nlohmann::ordered_json status() const;

 private:
  enum class By : std::uint8_t { kFile, kSignal, kOperator, kUndo };
  static const char* to_string(By by) noexcept;

  Tuner::Verdict hand_over(std::unique_ptr<const control::Setup> setup);
  void collect();
  void note(By by, const TuneOutcome& outcome);
  nlohmann::ordered_json answer_set(const nlohmann::json& values);
  nlohmann::ordered_json list() const;
  nlohmann::ordered_json tuned() const;

  CommandLine line_;
  SetupExchange& exchange_;
  Log& log_;
  Tuner tuner_;
  FileWatch watch_;
  std::string watch_problem_told_;
  Record last_;
  double at_s_ = 0.0;
  nlohmann::ordered_json last_attempt_;
  std::atomic<bool> reload_asked_{false};
};

}  // namespace geodesic::tools
