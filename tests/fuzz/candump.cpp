// Fuzz target: lines as candump writes them, and what `geodesic decode` makes of their frames.
#include "tools/geodesic/candump.hpp"

#include <linux/can.h>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/families.hpp"
#include "tests/drivers/family_benches.hpp"
#include "tests/fuzz/family_frames.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {

void candump(Bytes bytes) {
  // A copy of just this size: reading past the end shows.
  const std::string line(as_text(bytes));
  const std::vector<char> exact(line.begin(), line.end());
  std::string why = "left over";
  const auto parsed = tools::parse_candump({exact.data(), exact.size()}, why);
  if (!parsed) {
    const std::size_t first = line.find_first_not_of(" \t\r\n");
    expect(!why.empty() || first == std::string::npos || line[first] == '#',
           "a line that is refused is told why");
    return;
  }
  const drivers::Frame& frame = parsed->frame;
  expect(why.empty(), "no complaint of a line that was taken");
  expect(!parsed->interface.empty(), "a frame came by an interface");
  expect(frame.id <= (frame.extended || frame.error ? CAN_EFF_MASK : CAN_SFF_MASK),
         "identifier without flags");
  expect(frame.remote || drivers::is_can_length(frame.length, frame.fd), "a length of CAN");
  static const std::vector<drivers::test::FamilyBench> benches = drivers::test::family_benches();
  for (const drivers::test::FamilyBench& bench : benches) {
    expect_words(bench.of().decode(frame, bench.options));
  }
}

}  // namespace geodesic::fuzz
