// What the bare exchange is told on its command line. What it does is in bare_exchange.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace geodesic::bench {

struct BareOptions {
  std::string role;  ///< "commander", "responder" or "pair"
  std::vector<std::string> buses;
  std::vector<std::uint32_t> ids;
  std::vector<std::uint32_t> reply_ids;
  std::uint8_t length = 8;
  bool extended = false;
  bool fd = false;
  std::int64_t cycles = 10'000;
  std::int64_t warm_up = 200;
  std::int64_t period_ns = 1'000'000;
  double budget = 0.9;
  int priority = 80;
  int cpu = -1;
  std::int64_t reply_gap_ns = 0;
  bool json = false;
};

/// Ends the program with a sentence where the command line says what cannot be.
BareOptions parse_bare_options(int argc, char** argv);

}  // namespace geodesic::bench
