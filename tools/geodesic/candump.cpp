// Reads lines as candump writes them; see the header. Format: can-utils, candump(1) and lib.c.
#include "tools/geodesic/candump.hpp"

#include <linux/can.h>

#include <algorithm>
#include <charconv>
#include <vector>

#include "drivers/bus/bit_timing.hpp"

namespace geodesic::tools {
namespace {

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kSpace = " \t\r\n";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kSpace); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSpace, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSpace, end);
  }
  return words;
}

std::optional<std::uint32_t> hex(std::string_view text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Three digits: 11 bits; eight: 29 bits, or an error frame by its flag.
bool set_id(std::string_view text, drivers::Frame& frame, std::string& why) {
  const std::optional<std::uint32_t> value = hex(text);
  if (!value || (text.size() != 3 && text.size() != 8)) {
    why = "'" + std::string(text) + "' is no identifier (3 or 8 hexadecimal digits)";
    return false;
  }
  frame.error = text.size() == 8 && (*value & CAN_ERR_FLAG) != 0;
  frame.extended = text.size() == 8 && !frame.error;
  frame.id = *value & (text.size() == 8 ? CAN_EFF_MASK : CAN_SFF_MASK);
  if (text.size() == 3 && *value > CAN_SFF_MASK) {
    why = "identifier " + std::string(text) + " has more than 11 bits";
    return false;
  }
  return true;
}

bool add_byte(std::string_view text, drivers::Frame& frame, std::string& why) {
  const std::optional<std::uint32_t> value = hex(text);
  if (!value || text.size() != 2) {
    why = "'" + std::string(text) + "' is no byte (2 hexadecimal digits)";
    return false;
  }
  if (frame.length == frame.data.size()) {
    why = "more than 64 bytes";
    return false;
  }
  frame.data[frame.length++] = static_cast<std::uint8_t>(*value);
  return true;
}

bool check_length(const drivers::Frame& frame, std::string& why) {
  if (drivers::is_can_length(frame.length, frame.fd)) return true;
  why = std::to_string(frame.length) + " bytes do not fit a " +
        (frame.fd ? "CAN FD" : "classic CAN") + " frame";
  return false;
}

// "", "0" to "8": how many bytes are asked for.
bool remote(std::string_view length, CandumpLine& result, std::string& why) {
  const std::optional<std::uint32_t> bytes = length.empty() ? 0U : hex(length.substr(0, 1));
  if (!bytes || *bytes > CAN_MAX_DLEN) {
    why = "'" + std::string(length) + "' is no length of a remote frame (0 to 8)";
    return false;
  }
  result.frame.remote = true;
  result.frame.length = static_cast<std::uint8_t>(*bytes);
  return true;
}

// 123#0011, 12345678#R, 123#R8, 123##1AABB
bool compact(std::string_view text, CandumpLine& result, std::string& why) {
  const std::size_t hash = text.find('#');
  if (!set_id(text.substr(0, hash), result.frame, why)) return false;
  std::string_view data = text.substr(hash + 1);
  if (data.starts_with('R')) {
    return remote(data.substr(1), result, why);
  }
  if (data.starts_with('#')) {
    const std::optional<std::uint32_t> flags = hex(data.substr(1, 1));
    if (!flags) {
      why = "no flags after '##'";
      return false;
    }
    result.frame.fd = true;
    result.frame.bit_rate_switch = (*flags & CANFD_BRS) != 0;
    data.remove_prefix(2);
  }
  while (!data.empty()) {
    if (data.front() == '.') {
      data.remove_prefix(1);
      continue;
    }
    if (data.front() == '_') break;  // raw DLC of a classic frame
    if (!add_byte(data.substr(0, 2), result.frame, why)) return false;
    data.remove_prefix(std::min<std::size_t>(2, data.size()));
  }
  return check_length(result.frame, why);
}

// 123 [8] 00 11 ...; CAN FD has two digits between the brackets: 123 [08] ...
bool spaced(const std::vector<std::string_view>& words, std::size_t first, CandumpLine& result,
            std::string& why) {
  if (!set_id(words[first], result.frame, why)) return false;
  const std::string_view length = words[first + 1];
  result.frame.fd = length.size() == 4;
  result.frame.bit_rate_switch = result.frame.fd;  // plain candump does not tell without -x
  std::size_t count = 0;
  const char* const last = length.data() + length.size() - 1;  // "[" alone is its own last letter
  const auto [end, error] = std::from_chars(std::min(length.data() + 1, last), last, count);
  if (error != std::errc() || end != last || *last != ']' || count > result.frame.data.size()) {
    why = "'" + std::string(length) + "' is no length";
    return false;
  }
  if (words.size() > first + 2 && words[first + 2] == "remote") {
    result.frame.fd = false;
    result.frame.bit_rate_switch = false;
    return remote(length.substr(1, length.size() - 2), result, why);
  }
  if (words.size() < first + 2 + count) {
    why = "fewer bytes than " + std::string(length) + " says";
    return false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!add_byte(words[first + 2 + i], result.frame, why)) return false;
  }
  return check_length(result.frame, why);
}

}  // namespace

std::optional<CandumpLine> parse_candump(std::string_view line, std::string& why) {
  why.clear();
  const std::vector<std::string_view> words = words_of(line);
  if (words.empty() || words.front().starts_with('#')) return std::nullopt;
  CandumpLine result;
  std::size_t next = 0;
  if (words[0].starts_with('(')) {
    std::string time;
    while (next < words.size()) {  // absolute dates hold a space
      time += (time.empty() ? "" : " ") + std::string(words[next]);
      if (words[next++].ends_with(')')) break;
    }
    if (!time.ends_with(')')) {
      why = "'(' without ')'";
      return std::nullopt;
    }
    result.time = time.substr(1, time.size() - 2);
  }
  if (next + 1 >= words.size()) {
    why =
        "no frame behind the interface; expected a line of `candump -L`, as in "
        "(1436509052.249713) can0 001#7FFF7FF0000007FF";
    return std::nullopt;
  }
  result.interface = words[next++];
  // candump -x: direction and flags before the identifier.
  while (next < words.size() && (words[next] == "RX" || words[next] == "TX" || words[next] == "-" ||
                                 words[next] == "B" || words[next] == "E")) {
    ++next;
  }
  bool good = false;
  if (next < words.size() && words[next].find('#') != std::string_view::npos) {
    good = compact(words[next], result, why);
  } else if (next + 1 < words.size() && words[next + 1].starts_with('[')) {
    good = spaced(words, next, result, why);
  } else {
    why = "no frame in the form ID#DATA or ID [LENGTH] DATA";
  }
  if (!good) return std::nullopt;
  return result;
}

}  // namespace geodesic::tools
