// Which RobStride and CyberGear drives answer on a bus: asks for identities and parameters, which
// no drive obeys by moving or stopping. Writes nothing. Setting a zero is zeroing.hpp's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/robstride/codec.hpp"

namespace geodesic::drivers::robstride {

/// Asks 1 to 127 for their identity, twice, then those that answered for what they are. Not on a
/// bus in operation: an identity that comes unasked is a drive that was switched off and on. The
/// version is not asked for, since the question stops a motor.
class Scanner final : public drivers::Scanner {
 public:
  static constexpr std::int64_t kSettleNs = 50'000'000;  ///< for the last identities
  static constexpr std::int64_t kDetailNs = 20'000'000;  ///< for a parameter
  static constexpr int kTries = 3;                       ///< of such a parameter
  static constexpr std::uint32_t kRounds = 2;

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return over_; }
  std::vector<FoundDrive> found() const override;

 private:
  static constexpr std::array kDetails = {Index::kTorqueLimit, Index::kTimeout, Index::kZeroState,
                                          Index::kCyberGearTimeout};

  struct Answering {
    std::array<std::uint8_t, 8> mcu{};
    bool twice = false;  ///< two of different make answered to one id
    std::map<Index, ParameterAnswer> parameters;
  };

  void next_detail();
  static FoundDrive describe(std::uint8_t id, const Answering& drive);

  bool over_ = false;
  std::uint32_t asked_ = 0;  ///< identities asked for
  bool settled_ = false;
  std::map<std::uint8_t, Answering> drives_;
  std::map<std::uint8_t, Answering>::iterator drive_;  ///< whose details are asked, once settled_
  std::size_t detail_ = 0;
  int tries_ = 0;
  bool awaiting_ = false;
  std::int64_t asked_ns_ = 0;
};

}  // namespace geodesic::drivers::robstride
