// Fuzz target: the drive side of every family: any frames, any registers, any shaft.
#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/families.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {
namespace {

using drivers::DriveOptions;
using drivers::Family;
using drivers::Frame;

DriveOptions options_of(const Family& family, bool fd) {
  DriveOptions options;
  options.family = family.name;
  options.id = 0x05;
  options.reply_id = 0x15;
  options.fd = fd;
  options.position_range_rad = 12.5;
  options.velocity_range_rad_s = 30.0;
  options.torque_range_nm = 10.0;
  return options;
}

/// Physics moves shafts to places, not to infinity; how far is its affair.
double finite(Input& input, double scale) {
  const double value = input.real(scale);
  return std::abs(value) <= 1e6 ? value : 0.0;
}

Frame frame_from(Input& input, const DriveOptions& options) {
  constexpr std::array<std::uint32_t, 8> kTo{0x7FF, 0x7FF, 0x7FF, 0x05, 0x05, 0x105, 0x205, 0x305};
  Frame frame;
  const std::size_t kind = input.below(16);
  frame.id = kind == 15 ? static_cast<std::uint32_t>(input.integer(2)) : kTo[kind % kTo.size()];
  frame.fd = options.fd;
  frame.extended = kind == 14;
  frame.length = static_cast<std::uint8_t>(kind == 13 ? input.below(65) : 8);
  // Register frames begin with the drive's number: spare the fuzzer that guess.
  if (frame.id == 0x7FF && input.below(8) != 0) {
    frame.data[0] = static_cast<std::uint8_t>(options.id);
    frame.data[2] = std::array<std::uint8_t, 4>{0x33, 0x55, 0xAA, 0xCC}[input.below(4)];
    frame.data[3] = input.byte();
    const Bytes value = input.take(4);
    std::copy(value.begin(), value.end(), frame.data.begin() + 4);
    return frame;
  }
  const Bytes data = input.take(frame.length);
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

}  // namespace

void simulated(Bytes bytes) {
  Input input(bytes);
  const Family& family = drivers::families()[input.below(drivers::families().size())];
  const DriveOptions options = options_of(family, input.flag());
  const auto drive = family.make_simulated(options);
  std::int64_t now_ns = 0;
  while (!input.empty()) {
    now_ns += static_cast<std::int64_t>(input.integer(3));
    std::array<Frame, 1> reply;
    switch (input.below(8)) {
      case 0:
        drive->set_shaft(finite(input, 20.0), finite(input, 40.0));
        break;
      case 1:
        drive->set_temperature(finite(input, 200.0));
        break;
      case 2:
        input.flag() ? drive->power_cycle() : drive->inject_error(input.byte());
        break;
      default: {
        const Frame frame = frame_from(input, options);
        const std::size_t count = drive->receive(frame, now_ns, reply);
        expect(count <= 1, "at most one reply to a frame");
        expect(count == 0 || (reply[0].id <= 0x7FF && !reply[0].extended && !reply[0].error &&
                              drivers::is_can_length(reply[0].length, reply[0].fd)),
               "a reply is a frame that a bus can carry");
        const auto words = family.decode(frame, options);
        expect(!words || !words->kind.empty(), "what is understood has a name");
        for (const auto& field : words ? words->fields : std::vector<drivers::DecodedField>{}) {
          expect(!field.name.empty() && !field.value.empty() && is_printable(field.value) &&
                     is_printable(field.unit),
                 "every field has a name and a value that can be shown");
        }
        break;
      }
    }
    const double torque_nm = drive->torque_nm(now_ns);
    expect(std::isfinite(torque_nm), "physics gets a torque that is a number");
    expect(drive->enabled() || torque_nm == 0.0, "no torque from a drive that is not enabled");
    expect(family.error_name(input.byte()) != nullptr, "every error code has words");
  }
}

}  // namespace geodesic::fuzz
