// Looking for moteus drives on a CAN FD bus. What is printed of them is the tools'.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/moteus/codec.hpp"

namespace geodesic::drivers::moteus {

/// Asks every identifier without a prefix in turn, twice if need be, by reads only.
class Scanner final : public drivers::Scanner {
 public:
  static constexpr std::int64_t kProbeNs = 4'000'000;

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return over_; }
  std::vector<FoundDrive> found() const override { return found_; }

 private:
  std::uint32_t probed_ = 0;
  bool answered_ = true;
  bool again_ = false;
  bool over_ = false;
  std::int64_t asked_ns_ = 0;
  std::vector<FoundDrive> found_;
};

}  // namespace geodesic::drivers::moteus
