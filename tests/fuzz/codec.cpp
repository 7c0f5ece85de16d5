// Fuzz target: Damiao frames <-> numbers, any bytes one way and any numbers the other; and any
// bytes to whatever decodes frames of a family: its words for people and its driver.
#include "drivers/damiao/codec.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "rt/heap_counter.hpp"
#include "tests/drivers/family_benches.hpp"
#include "tests/fuzz/family_frames.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {
namespace {

using namespace drivers::damiao;  // NOLINT(google-build-using-namespace): the codec under test
using drivers::Frame;

constexpr std::array kModels = {Ranges{12.5, 30.0, 10.0}, Ranges{12.5, 45.0, 54.0},
                                Ranges{12.5, 10.0, 28.0}, Ranges{3.141593, 8.0, 0.5}};

bool same_bytes(const Frame& a, const Frame& b) {
  return a.length == b.length && std::memcmp(a.data.data(), b.data.data(), a.length) == 0;
}

bool within(double value, double least, double most) {
  const double slack = 1e-9 * (most - least);
  return std::isfinite(value) && value >= least - slack && value <= most + slack;
}

void decode_all(const Frame& frame, const Ranges& ranges) {
  const auto special = decode_special(frame);
  const auto mit = decode_mit(frame, ranges);
  expect(!mit || !special, "a special frame is no command");
  expect(mit.has_value() == (frame.length == 8 && !special), "every other frame of 8 bytes is one");
  if (mit) {
    expect(within(mit->position_rad, -ranges.position_rad, ranges.position_rad) &&
               within(mit->velocity_rad_s, -ranges.velocity_rad_s, ranges.velocity_rad_s) &&
               within(mit->torque_nm, -ranges.torque_nm, ranges.torque_nm) &&
               within(mit->stiffness_nm_rad, 0.0, mit::kMaxStiffness) &&
               within(mit->damping_nm_s_rad, 0.0, mit::kMaxDamping),
           "a command's figures are finite and in range");
    const auto again = encode_mit(frame.id, false, *mit, ranges);
    expect(again && same_bytes(*again, frame), "encode(decode(command)) is the command");
  }
  if (special) {
    expect(same_bytes(encode_special(frame.id, false, *special), frame), "special round trip");
  }
  const auto report = decode_report(frame, ranges);
  expect(report.has_value() == (frame.length == 8), "every frame of 8 bytes is a report");
  if (report) {
    expect(within(report->position_rad, -ranges.position_rad, ranges.position_rad) &&
               within(report->velocity_rad_s, -ranges.velocity_rad_s, ranges.velocity_rad_s) &&
               within(report->torque_nm, -ranges.torque_nm, ranges.torque_nm) &&
               within(report->mosfet_c, 0.0, 255.0) && within(report->rotor_c, 0.0, 255.0) &&
               report->status < 16 && report->motor < 16,
           "a report's figures are finite and in range");
  }
  if (const auto answer = decode_register(frame)) {
    const Frame again = encode_write(answer->id, false, answer->number, answer->raw);
    Frame as_write = frame;
    as_write.data[2] = static_cast<std::uint8_t>(Operation::kWrite);
    expect(same_bytes(again, as_write), "register round trip");
  }
  if (const auto command = decode_position_velocity(frame)) {
    const auto again = encode_position_velocity(0, false, *command);
    expect(again && same_bytes(*again, frame), "position-velocity: finite, and a round trip");
  }
  if (const auto velocity = decode_velocity(frame)) {
    const auto again = encode_velocity(0, false, *velocity);
    expect(again && std::memcmp(again->data.data(), frame.data.data(), 4) == 0,
           "velocity: finite, and a round trip");
  }
  if (const auto command = decode_position_force(frame)) {
    const auto again = encode_position_force(0, false, *command);
    expect(again.has_value(), "position-force: finite");
    if (command->velocity_limit_rad_s <= 100.0 && command->current_limit <= 1.0) {
      expect(same_bytes(*again, frame), "position-force round trip");
    }
  }
}

/// What a drive takes `value` for is at most half a code away from it, or from the end of the span;
/// one code and a half where `yields` had to make room for a special frame.
void near(double value, double decoded, double low, double high, unsigned bits, bool yields) {
  const double wanted = std::fmin(std::fmax(value, low), high);
  const double code = (high - low) / static_cast<double>((1U << bits) - 1U);
  expect(std::abs(decoded - wanted) <= (yields ? 1.5001 : 0.5001) * code, "rounded to nearest");
}

void encode_all(Input& input, const Ranges& ranges) {
  const MitCommand command{input.real(2.0 * ranges.position_rad),
                           input.real(2.0 * ranges.velocity_rad_s), input.real(600.0),
                           input.real(6.0), input.real(2.0 * ranges.torque_nm)};
  const bool finite = std::isfinite(command.position_rad) &&
                      std::isfinite(command.velocity_rad_s) &&
                      std::isfinite(command.stiffness_nm_rad) &&
                      std::isfinite(command.damping_nm_s_rad) && std::isfinite(command.torque_nm);
  const auto frame = encode_mit(1, input.flag(), command, ranges);
  expect(frame.has_value() == finite, "refused if and only if a figure is not finite");
  if (!frame) return;
  expect(!decode_special(*frame), "a command never looks like a special frame");
  const auto taken = decode_mit(*frame, ranges);
  expect(taken.has_value(), "what was encoded is a command");
  const auto near_signed = [](double value, double decoded, double range, unsigned bits) {
    near(value, decoded, -range, range, bits, false);
  };
  near_signed(command.position_rad, taken->position_rad, ranges.position_rad, 16);
  near_signed(command.velocity_rad_s, taken->velocity_rad_s, ranges.velocity_rad_s, 12);
  near_signed(command.torque_nm, taken->torque_nm, ranges.torque_nm, 12);
  near(command.stiffness_nm_rad, taken->stiffness_nm_rad, 0.0, 500.0, 12, false);
  near(command.damping_nm_s_rad, taken->damping_nm_s_rad, 0.0, 5.0, 12,
       taken->torque_nm > 0.99 * ranges.torque_nm);
}

/// Frames of one family, one after the other, at any time.
void decode_family(Input& input) {
  static const std::vector<drivers::test::FamilyBench> benches = drivers::test::family_benches();
  const drivers::test::FamilyBench& bench = benches[input.below(benches.size())];
  const auto drive = bench.of().make_drive(bench.options);
  std::vector<drivers::IdFilter> ids = drive->reply_ids();
  const std::vector<drivers::IdFilter> replies = ids;
  const std::vector<drivers::IdFilter> commands = drive->command_ids();
  ids.insert(ids.end(), commands.begin(), commands.end());
  std::int64_t now_ns = 1'000'000'000;
  while (!input.empty()) {
    now_ns += static_cast<std::int64_t>(input.integer(2)) * 10'000;
    const Frame frame = forged(input, ids, bench.options.fd);
    expect_words(bench.of().decode(frame, bench.options));
    if (!matches(replies, frame) || !drive->claims(frame)) continue;
    const std::uint64_t calls = rt::heap_calls();
    drive->receive({frame, now_ns});
    expect(rt::heap_calls() == calls, "receive() never touches the heap");
    const drivers::DriveState& state = drive->state();
    expect(std::isfinite(state.position_rad) && std::isfinite(state.velocity_rad_s) &&
               std::isfinite(state.torque_nm) && std::isfinite(state.temperature_c),
           "a drive's state is finite");
    expect(state.condition != control::DriveCondition::kEnabled,
           "nobody is enabled who was not asked");
  }
}

}  // namespace

void codec(Bytes bytes) {
  Input input(bytes);
  const Ranges& ranges = kModels[input.below(kModels.size())];
  const std::size_t which = input.below(4);
  if (which >= 2) {
    decode_family(input);
    return;
  }
  const std::uint64_t calls = rt::heap_calls();
  if (which == 1) {
    encode_all(input, ranges);
  } else {
    Frame frame;
    frame.id = 1;
    const std::size_t length = input.below(16);
    frame.length = static_cast<std::uint8_t>(length > 8 ? 8 : length);
    const Bytes data = input.take(frame.length);
    std::memcpy(frame.data.data(), data.data(), data.size());
    decode_all(frame, ranges);
  }
  expect(rt::heap_calls() == calls, "the codec never touches the heap");
}

}  // namespace geodesic::fuzz
