// Writing down zeros; see the header.
#include "tools/geodesic/zero_record.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "drivers/bus/descriptor.hpp"
#include "tools/geodesic/command.hpp"

namespace geodesic::tools {
namespace {

drivers::Descriptor open_record(const std::filesystem::path& file) {
  drivers::Descriptor opened(::open(file.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644));
  if (!opened.valid()) {
    throw BadInput(fmt::format("cannot append to {}, where zeros are recorded: {}", file.string(),
                               std::strerror(errno)));
  }
  return opened;
}

nlohmann::ordered_json figure(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

std::filesystem::path zero_record_file(const std::filesystem::path& robot_file) {
  std::filesystem::path file = robot_file;
  return file.replace_extension(".zeros.jsonl");
}

void prepare_record(const std::filesystem::path& file) {
  open_record(file);
}

std::string to_json_line(const ZeroRecord& record) {
  const nlohmann::ordered_json line{{"when", record.when},
                                    {"who", record.who},
                                    {"joint", record.joint},
                                    {"interface", record.interface},
                                    {"family", record.family},
                                    {"drive_id", record.drive_id},
                                    {"done", record.done},
                                    {"before_rad", figure(record.before_rad)},
                                    {"after_rad", figure(record.after_rad)},
                                    {"report", record.report}};
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void append_record(const std::filesystem::path& file, const ZeroRecord& record) {
  const drivers::Descriptor opened = open_record(file);
  const std::string line = to_json_line(record);
  if (::write(opened.get(), line.data(), line.size()) != static_cast<ssize_t>(line.size()) ||
      (::fsync(opened.get()) != 0 && errno != EINVAL)) {
    throw BadInput(fmt::format("cannot append to {}: {}; the line is: {}", file.string(),
                               std::strerror(errno), line));
  }
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

std::string who_am_i() {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
  const char* const sudo = std::getenv("SUDO_USER");
  const passwd* const user = ::getpwuid(::getuid());
  const std::string name = sudo != nullptr && *sudo != '\0' ? std::string(sudo)
                           : user != nullptr                ? std::string(user->pw_name)
                                                            : std::to_string(::getuid());
  return fmt::format("{}@{}", name, host.data());
}

}  // namespace geodesic::tools
