// Which Damiao drives answer on a bus: asks for registers and states, which no drive obeys by
// moving. Writes nothing. Setting a zero is zeroing.hpp's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/damiao/codec.hpp"

namespace geodesic::drivers::damiao {

/// Asks every identifier that a drive may have for register 8 (ESC_ID), one after the other, then
/// those that answered for what they are. Whose answer it is stands in the answer's data, since
/// nobody knows yet where a drive answers.
class Scanner final : public drivers::Scanner {
 public:
  static constexpr std::uint32_t kLastId = 0xFF;
  static constexpr std::int64_t kProbeNs = 4'000'000;    ///< each identifier has so long
  static constexpr std::int64_t kLateNs = 60'000'000;    ///< and the last ones so long
  static constexpr std::int64_t kDetailNs = 20'000'000;  ///< a register of one that is there
  static constexpr int kTries = 3;                       ///< of such a register

  explicit Scanner(bool fd) : fd_(fd) {}

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return over_; }
  std::vector<FoundDrive> found() const override;

 private:
  /// What is asked of a drive that has answered; the state comes last.
  static constexpr std::array kDetails = {
      Register::kTimeout,     Register::kControlMode,   Register::kHardware,
      Register::kFirmware,    Register::kPositionRange, Register::kVelocityRange,
      Register::kTorqueRange, Register::kSubVersion,
  };

  struct Answering {
    std::uint32_t id = 0;
    std::uint32_t reply_id = 0;
    bool twice = false;  ///< it answered twice to one question
    std::map<Register, std::uint32_t> registers;
    std::optional<std::uint8_t> status;
  };

  void next_detail();
  FoundDrive describe(const Answering& drive) const;

  bool fd_;
  bool over_ = false;
  std::uint32_t probed_ = 0;  ///< the last identifier that was asked
  std::size_t drive_ = 0;     ///< whose details are asked
  std::size_t detail_ = 0;    ///< which; kDetails.size(): its state
  int tries_ = 0;
  bool awaiting_ = false;
  std::int64_t asked_ns_ = 0;
  std::vector<Answering> drives_;
};

}  // namespace geodesic::drivers::damiao
