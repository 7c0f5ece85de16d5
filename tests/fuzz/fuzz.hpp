// What every fuzz target is made of: the table of targets, a reader of the fuzzer's bytes, and the
// check whose failure is a finding. What a target checks stands in its own file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace geodesic::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// One target: takes any bytes and throws Violation if what must hold for them does not.
struct Target {
  std::string_view name;
  void (*run)(Bytes);
};

void frames(Bytes input);          ///< SocketCAN and socket-bus messages, error frames (frames.cpp)
void codec(Bytes input);           ///< Damiao frames <-> numbers (codec.cpp)
void drives(Bytes input);          ///< host side of every drive family (drives.cpp)
void simulated(Bytes input);       ///< drive side of every drive family (simulated.cpp)
void candump(Bytes input);         ///< lines of candump and what they mean (candump.cpp)
void states(Bytes input);          ///< the file of `geodesic model --states` (states.cpp)
void requests(Bytes input);        ///< one line to the control socket (requests.cpp)
void control_stream(Bytes input);  ///< the control socket itself (control_stream.cpp)
void robot_file(Bytes input);      ///< the robot's TOML (robot_file.cpp)
void urdf(Bytes input);            ///< the robot's URDF (urdf.cpp)

/// Every target there is, for those who replay; a fuzzer is linked with one of them.
inline constexpr Target kTargets[] = {
    {"frames", frames},         {"codec", codec},
    {"drives", drives},         {"simulated", simulated},
    {"candump", candump},       {"states", states},
    {"requests", requests},     {"control_stream", control_stream},
    {"robot_file", robot_file}, {"urdf", urdf},
};

/// A finding: what did not hold. Nobody catches it in a fuzzer, so that the stack is shown.
class Violation : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// @throws Violation if `holds` is false.
void expect(bool holds, std::string_view what);

/// Takes the fuzzer's bytes apart. Past the end everything is 0.
class Input {
 public:
  explicit Input(Bytes bytes) : rest_(bytes) {}

  bool empty() const { return rest_.empty(); }
  std::uint8_t byte();
  std::uint64_t integer(std::size_t bytes);
  /// Below `count`, which is above 0.
  std::size_t below(std::size_t count) { return integer(count > 256 ? 2 : 1) % count; }
  bool flag() { return (byte() & 1U) != 0; }
  /// Any double: often a plain one in +-`scale`, at times one of the nasty kind, at times any bits.
  double real(double scale);
  Bytes take(std::size_t most);
  Bytes rest() { return take(rest_.size()); }

 private:
  Bytes rest_;
};

std::string_view as_text(Bytes bytes);
/// Whether it is UTF-8 without control characters: what may be shown on anybody's terminal.
bool is_printable(std::string_view text);

/// A folder for this process (in TMPDIR; best a file system in memory) that goes when it ends.
const std::filesystem::path& scratch_folder();
/// Puts a file there. @return its path.
std::filesystem::path write_scratch(std::string_view name, std::string_view text);
/// A file of the project's source, whole.
std::string source_text(std::string_view path);

}  // namespace geodesic::fuzz
