// The daemon's log: one line an event, through spdlog, as the reader of stdout expects it. Not for
// the real-time thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace spdlog {
class logger;
namespace sinks {
class sink;
}
}  // namespace spdlog

namespace geodesic::tools {

enum class Severity : std::uint8_t { kDebug, kInfo, kWarning, kError, kCritical };

/// Names as --log-level takes them: debug, info, warning, error, critical.
const std::vector<std::string>& severity_names();

struct LogOptions {
  Severity level = Severity::kInfo;
  bool json = false;
  /// stdout is the journal's ($JOURNAL_STREAM names it): lines begin with their syslog priority
  /// "<4>", and time and colour are left to the journal.
  bool journal = false;
  bool colour = false;  ///< stdout is a terminal

  /// What stdout is, by isatty() and the environment.
  static LogOptions for_stdout();
};

class Log {
 public:
  /// To stdout.
  explicit Log(const LogOptions& options);
  /// To a sink of the caller's, for tests.
  Log(const LogOptions& options, std::shared_ptr<spdlog::sinks::sink> sink);

  /// A reader of stdout who does not read (a full pipe, a terminal on hold) costs 50 ms once; from
  /// then on lines are dropped until it reads again, and then their number is said.
  /// @param fields  what the text says, for programs: added to the line with --json
  void write(Severity severity, std::string_view text,
             const nlohmann::ordered_json& fields = {}) noexcept;

  void debug(std::string_view text) noexcept { write(Severity::kDebug, text); }
  void info(std::string_view text) noexcept { write(Severity::kInfo, text); }
  void warning(std::string_view text) noexcept { write(Severity::kWarning, text); }
  void error(std::string_view text) noexcept { write(Severity::kError, text); }
  void critical(std::string_view text) noexcept { write(Severity::kCritical, text); }

 private:
  bool reader_takes_it() noexcept;

  bool json_;
  bool to_stdout_ = false;
  std::atomic<std::uint64_t> lost_{0};  // lines since the reader of stdout stopped reading
  std::shared_ptr<spdlog::logger> logger_;
};

}  // namespace geodesic::tools
