// The daemon's log through spdlog.
#include "tools/geodesicd/log.hpp"

#include <poll.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

namespace geodesic::tools {
namespace {

spdlog::level::level_enum spdlog_level(Severity severity) {
  switch (severity) {
    case Severity::kDebug:
      return spdlog::level::debug;
    case Severity::kInfo:
      return spdlog::level::info;
    case Severity::kWarning:
      return spdlog::level::warn;
    case Severity::kError:
      return spdlog::level::err;
    case Severity::kCritical:
      return spdlog::level::critical;
  }
  return spdlog::level::info;
}

/// "<3>" and the like, as sd-daemon(3) describes.
class SyslogPriority final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    std::string_view prefix = "<6>";
    if (message.level == spdlog::level::debug) {
      prefix = "<7>";
    } else if (message.level == spdlog::level::warn) {
      prefix = "<4>";
    } else if (message.level == spdlog::level::err) {
      prefix = "<3>";
    } else if (message.level == spdlog::level::critical) {
      prefix = "<2>";
    }
    out.append(prefix.data(), prefix.data() + prefix.size());
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<SyslogPriority>();
  }
};

/// The text as a JSON object {time, level, message}, or with its own fields where it has some.
std::string json_line(Severity severity, std::string_view text,
                      const nlohmann::ordered_json& fields) {
  const auto now = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  nlohmann::ordered_json line{{"time", static_cast<double>(now.count()) / 1000.0},
                              {"level", severity_names()[static_cast<std::size_t>(severity)]},
                              {"message", text}};
  if (fields.is_object()) {
    line.update(fields);
  }
  return line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::shared_ptr<spdlog::sinks::sink> stdout_sink(const LogOptions& options) {
  return std::make_shared<spdlog::sinks::stdout_color_sink_mt>(
      options.colour ? spdlog::color_mode::always : spdlog::color_mode::never);
}

}  // namespace

const std::vector<std::string>& severity_names() {
  static const std::vector<std::string> names{"debug", "info", "warning", "error", "critical"};
  return names;
}

LogOptions LogOptions::for_stdout() {
  LogOptions options;
  options.colour = ::isatty(STDOUT_FILENO) == 1;
  options.journal = !options.colour && std::getenv("JOURNAL_STREAM") != nullptr;
  return options;
}

Log::Log(const LogOptions& options) : Log(options, stdout_sink(options)) {
  to_stdout_ = true;
}

Log::Log(const LogOptions& options, std::shared_ptr<spdlog::sinks::sink> sink)
    : json_(options.json), logger_(std::make_shared<spdlog::logger>("geodesicd", std::move(sink))) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<SyslogPriority>('*');
  if (options.json) {
    formatter->set_pattern("%v");
  } else if (options.journal) {
    formatter->set_pattern("%*%v");
  } else {
    formatter->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
  }
  logger_->set_formatter(std::move(formatter));
  logger_->set_level(spdlog_level(options.level));
  logger_->flush_on(spdlog::level::debug);
  // A full disk or a closed pipe behind stdout must not end the daemon, nor be complained of there.
  logger_->set_error_handler([](const std::string&) {});
}

// A write to a full pipe would wait for its reader, and with the log all that the thread does for
// others. A pipe that polls writable takes any line of ours (up to PIPE_BUF) at once.
bool Log::reader_takes_it() noexcept {
  constexpr int kPatienceMs = 50;
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  const bool patient = lost_.load(std::memory_order_relaxed) == 0;
  return !to_stdout_ || ::poll(&out, 1, patient ? kPatienceMs : 0) != 0;
}

void Log::write(Severity severity, std::string_view text,
                const nlohmann::ordered_json& fields) noexcept {
  const auto level = spdlog_level(severity);
  if (!logger_->should_log(level)) {
    return;
  }
  if (!reader_takes_it()) {
    lost_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  if (const std::uint64_t lost = lost_.exchange(0, std::memory_order_relaxed); lost > 0) {
    write(Severity::kWarning,
          std::to_string(lost) + " lines of the log are missing here: nobody read it");
  }
  try {
    const std::string line = json_ ? json_line(severity, text, fields) : std::string(text);
    logger_->log(level, spdlog::string_view_t(line));
  } catch (
      ...) {  // NOLINT(bugprone-empty-catch): out of memory for a log line is no reason to stop
  }
}

}  // namespace geodesic::tools
