// What is asked of a drive and told to it on its way from reset to operational, in order: a list
// made from the options. Who walks it is start_up.hpp's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/cia402/layout.hpp"
#include "drivers/cia402/settings.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::cia402 {

/// One transfer. A drive that aborts it is refused, unless it may lack the object.
struct Transfer {
  enum class Kind : std::uint8_t {
    kRead,   ///< compare what comes
    kAwait,  ///< as kRead, repeated for a while until it is so
    kWrite,
  };
  enum class Compare : std::uint8_t { kAny, kEqual, kAllBits, kAtLeast };
  Kind kind = Kind::kRead;
  Object object;
  std::uint32_t value = 0;  ///< to write, or to compare with
  Compare compare = Compare::kEqual;
  std::uint32_t mask = 0xFFFFFFFF;  ///< of what is compared
  bool may_lack = false;
  std::uint8_t skipped_if_lacking = 0;  ///< transfers that follow and hang on this one
  const char* quantity = "";            ///< name, index:sub and unit, a literal
  const char* fix = "";                 ///< of a mismatch, a literal
};

struct Plan {
  static constexpr std::size_t kMost = 72;
  std::array<Transfer, kMost> transfers{};
  std::size_t count = 0;
  /// From here on what TPDOs say means what we take it for: all figures have been compared.
  std::size_t figures_end = 0;
};

/// @param options  must pass check().
Plan make_plan(const DriveOptions& options, const Units& units) noexcept;

}  // namespace geodesic::drivers::cia402
