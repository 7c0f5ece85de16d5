// Which CiA 402 drives answer on a bus: one read of the device type to each node, then what those
// that are drives tell of themselves. Reads only. Not real-time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/cia402/codec.hpp"

namespace geodesic::drivers::cia402 {

class CanopenScanner final : public Scanner {
 public:
  static constexpr std::int64_t kPatienceNs = 100'000'000;

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return over_; }
  std::vector<FoundDrive> found() const override;

 private:
  static constexpr std::size_t kFacts = 13;
  struct Node {
    std::uint32_t id = 0;
    std::array<std::optional<std::uint32_t>, kFacts> facts;
  };

  FoundDrive describe(const Node& node) const;

  std::uint32_t called_ = 0;  ///< the last node that was asked for its type
  std::vector<Node> nodes_;
  std::size_t node_ = 0;  ///< that is being asked, and for which fact
  std::size_t fact_ = 0;
  bool awaiting_ = false;
  std::int64_t asked_ns_ = 0;
  bool over_ = false;
};

}  // namespace geodesic::drivers::cia402
