// Finds ODrives on a bus: hears their heartbeats, then asks each for its version.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "drivers/bench_dialogue.hpp"

namespace geodesic::drivers::odrive {

/// Contracts as drivers::Scanner. A node that sends no heartbeat is not found: to ask all 63 would
/// speak to other families' drives.
class OdriveScanner final : public Scanner {
 public:
  static constexpr std::int64_t kListenNs = 700'000'000;
  static constexpr std::int64_t kReplyTimeoutNs = 30'000'000;
  static constexpr int kAsks = 4;  ///< for each of version and error

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return over_; }
  std::vector<FoundDrive> found() const override;

 private:
  struct Node {
    int heartbeats = 0;
    std::int64_t heartbeat_ns = 0;
    Frame heartbeat;
    std::optional<Frame> version;
    int error_answers = 0;
    int estimates = 0;
    bool strange = false;  ///< what it sends is no heartbeat
  };

  std::map<std::uint32_t, Node> nodes_;
  std::int64_t begun_ns_ = -1;
  std::int64_t next_ns_ = 0;
  std::size_t asks_ = 0;
  bool over_ = false;
};

}  // namespace geodesic::drivers::odrive
