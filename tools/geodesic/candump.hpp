// Reads lines as candump writes them (`candump -L`, and plain candump with or without -t). Knows
// nothing of drives.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "drivers/bus/frame.hpp"

namespace geodesic::tools {

struct CandumpLine {
  std::string time;  ///< as written, without parentheses; empty: none
  std::string interface;
  drivers::Frame frame;
};

/// @return nothing if the line is no frame; `why` then says what is wrong. Blank lines and comments
///         (#) give nothing and an empty `why`.
std::optional<CandumpLine> parse_candump(std::string_view line, std::string& why);

}  // namespace geodesic::tools
