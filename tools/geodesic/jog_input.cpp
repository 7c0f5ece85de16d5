// Keys and lines for jogging; see the header.
#include "tools/geodesic/jog_input.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <utility>

#include "config/findings.hpp"

namespace geodesic::tools {
namespace {

constexpr std::size_t kLongestLine = 64;
constexpr int kMostReads = 64;  ///< a cycle, 1 KiB each: whoever floods us does not hold us up
constexpr char kEscape = '\033';
constexpr char kEndOfText = '\004';

}  // namespace

JogInput::JogInput(int file, double torque)
    : file_(file), torque_(torque), flags_(::fcntl(file, F_GETFL)) {
  if (flags_ >= 0) ::fcntl(file_, F_SETFL, flags_ | O_NONBLOCK);
  if (::tcgetattr(file_, &before_) == 0) {
    terminal_ = true;
    termios keys = before_;
    keys.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // ISIG stays: Ctrl-C ends it
    keys.c_cc[VMIN] = 1;  // without a key EAGAIN, so that 0 is a terminal that has gone
    keys.c_cc[VTIME] = 0;
    keys.c_cc[VSUSP] = _POSIX_VDISABLE;  // a stopped program would leave the drive to its watchdog
    ::tcsetattr(file_, TCSANOW, &keys);
  }
}

JogInput::~JogInput() {
  if (terminal_) ::tcsetattr(file_, TCSANOW, &before_);
  if (flags_ >= 0) ::fcntl(file_, F_SETFL, flags_);
}

std::string JogInput::take_complaint() {
  return std::exchange(complaint_, {});
}

void JogInput::poll(std::int64_t now_ns) {
  std::array<char, 1024> bytes;
  for (int i = 0; i < kMostReads && !ended_; ++i) {
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count <= 0) {
      ended_ = true;
      request_ = {};
      return;
    }
    const std::string_view text(bytes.data(), static_cast<std::size_t>(count));
    if (terminal_) {
      take_keys(text, now_ns);
      continue;
    }
    for (const char c : text) {
      if (c == '\n') {
        take_line(line_, now_ns);
        line_.clear();
      } else if (line_.size() <= kLongestLine) {
        line_ += c;
      }
    }
  }
}

void JogInput::take_keys(std::string_view keys, std::int64_t now_ns) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    char key = keys[i];
    if (key == kEscape && i + 2 < keys.size() && keys[i + 1] == '[') {
      i += 2;  // arrows: ESC [ A up, B down, C right, D left
      key = keys[i] == 'A' || keys[i] == 'C' ? '+' : keys[i] == 'B' || keys[i] == 'D' ? '-' : ' ';
    }
    if (key == '+' || key == '=' || key == 'd') {
      request_ = {torque_, now_ns};
    } else if (key == '-' || key == 'a') {
      request_ = {-torque_, now_ns};
    } else {
      request_ = {};  // any other key lets go
      ended_ = ended_ || key == 'q' || key == kEscape || key == kEndOfText;
    }
  }
}

void JogInput::take_line(std::string_view line, std::int64_t now_ns) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t first = line.find_first_not_of(kSpace);
  line = first == std::string_view::npos
             ? std::string_view()
             : line.substr(first, line.find_last_not_of(kSpace) - first + 1);
  request_ = {};
  if (line == "q" || line == "quit") {
    ended_ = true;
  } else if (line == "+" || line == "-") {
    request_ = {line == "+" ? torque_ : -torque_, now_ns};
  } else if (!line.empty()) {
    const std::string_view number = line.front() == '+' ? line.substr(1) : line;
    double torque = 0.0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), torque);
    if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(torque)) {
      complaint_ = fmt::format("{} is neither +, - nor a torque; q ends", config::quote(line));
    } else if (std::abs(torque) > torque_) {
      complaint_ = fmt::format("{:g} is more than the bound of {:g} (--torque)", torque, torque_);
    } else {
      request_ = {torque, now_ns};
    }
  }
}

}  // namespace geodesic::tools
