// Looks for CiA 402 drives; see scanner.hpp.
#include "drivers/cia402/scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace geodesic::drivers::cia402 {

namespace {

enum Fact : std::size_t {
  kVendorFact,
  kProductFact,
  kRevisionFact,
  kModesFact,
  kRatedFact,
  kIncrementsFact,
  kRevolutionsFact,
  kGearMotorFact,
  kGearShaftFact,
  kStatusFact,
  kWatchedFact,
  kMaxTorqueFact,
  kMaxSpeedFact,
};

constexpr std::array kObjects = {
    object::kVendor,
    object::kProduct,
    object::kRevision,
    object::kSupportedModes,
    object::kRatedTorque,
    object::kEncoderIncrements,
    object::kEncoderRevolutions,
    object::kGearMotor,
    object::kGearShaft,
    object::kStatusword,
    object::kConsumerHeartbeat,
    object::kMaxTorque,
    object::kMaxSpeed,
};

double ratio(std::optional<std::uint32_t> above, std::optional<std::uint32_t> below) {
  const double one = above.value_or(1);
  const double other = below.value_or(1);
  return one > 0.0 && other > 0.0 ? one / other : 1.0;
}

}  // namespace

std::optional<Frame> CanopenScanner::transmit(std::int64_t now_ns) {
  if (over_) {
    return std::nullopt;
  }
  if (called_ < kLastNode) {
    ++called_;
    asked_ns_ = now_ns;
    return encode_read(called_, object::kDeviceType);
  }
  if (node_ == 0 && fact_ == 0 && !awaiting_ && now_ns - asked_ns_ < kPatienceNs) {
    return std::nullopt;  // the last called may still answer
  }
  if (awaiting_ && now_ns - asked_ns_ < kPatienceNs) {
    return std::nullopt;
  }
  if (awaiting_) {
    awaiting_ = false;  // no answer: a fact it does not tell
    ++fact_;
  }
  if (fact_ == kObjects.size()) {
    fact_ = 0;
    ++node_;
  }
  if (node_ >= nodes_.size()) {
    over_ = true;
    return std::nullopt;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  return encode_read(nodes_[node_].id, kObjects[fact_]);
}

void CanopenScanner::receive(const ReceivedFrame& received) {
  static_assert(kObjects.size() == kFacts);
  const Frame& frame = received.frame;
  const std::uint32_t id = frame.id - cob::kSdoReply;
  const std::optional<Sdo> reply = decode_sdo_reply(frame);
  if (!reply || frame.id <= cob::kSdoReply || id > kLastNode) {
    return;
  }
  if (reply->index == object::kDeviceType.index) {
    const bool known =
        std::any_of(nodes_.begin(), nodes_.end(), [id](const Node& node) { return node.id == id; });
    if (reply->kind == Sdo::Kind::kReadReply && (reply->value & 0xFFFFU) == kDeviceProfile &&
        !known) {
      nodes_.push_back({id, {}});
    }
    return;
  }
  if (!awaiting_ || id != nodes_[node_].id || reply->index != kObjects[fact_].index ||
      reply->sub != kObjects[fact_].sub) {
    return;
  }
  if (reply->kind == Sdo::Kind::kReadReply) {
    nodes_[node_].facts[fact_] = reply->value;
  }
  awaiting_ = false;
  ++fact_;
}

FoundDrive CanopenScanner::describe(const Node& node) const {
  FoundDrive drive;
  drive.id = node.id;
  const auto& facts = node.facts;
  drive.model = fmt::format("CiA 402 drive, vendor 0x{:X}, product 0x{:X}",
                            facts[kVendorFact].value_or(0), facts[kProductFact].value_or(0));
  if (facts[kRevisionFact]) {
    drive.firmware = fmt::format("revision 0x{:08X}", *facts[kRevisionFact]);
  }
  const auto option = [&](Fact fact, const char* key) {
    if (facts[fact]) {
      drive.options.emplace_back(key, fmt::format("{}", *facts[fact]));
    }
  };
  option(kIncrementsFact, "encoder_increments");
  option(kRevolutionsFact, "encoder_revolutions");
  option(kGearMotorFact, "gear_motor_revolutions");
  option(kGearShaftFact, "gear_shaft_revolutions");
  option(kRatedFact, "rated_torque_mnm");
  drive.options.emplace_back("velocity_unit", "\"increments_per_s\"");
  const double gear = ratio(facts[kGearMotorFact], facts[kGearShaftFact]);
  const double torque_nm =
      facts[kMaxTorqueFact].value_or(1000) * 1e-3 * facts[kRatedFact].value_or(1000) * 1e-3 * gear;
  drive.options.emplace_back("torque_range_nm", fmt::format("{:.4f}", torque_nm));
  const double rad_s = facts[kMaxSpeedFact].value_or(3000) * 2.0 * std::numbers::pi / 60.0 / gear;
  drive.options.emplace_back("velocity_range_rad_s", fmt::format("{:.4f}", rad_s));
  drive.remarks.emplace_back(
      "torque_range_nm is its 0x6072 and velocity_range_rad_s its 0x6080 (3000 rpm if it has "
      "none), both "
      "behind the gear: lower them to what the joint bears");
  if (!facts[kRatedFact]) {
    drive.remarks.emplace_back(
        "it does not tell its rated torque (0x6076): take rated_torque_mnm "
        "from its manual, with rated_torque_check = \"manual\"");
  }
  if (!facts[kIncrementsFact]) {
    drive.remarks.emplace_back(
        "it does not tell its encoder's increments (0x608F): take "
        "encoder_increments from its manual, with encoder_check = \"manual\"");
  }
  if ((facts[kModesFact].value_or(0) & kCyclicTorqueBit) == 0) {
    drive.remarks.emplace_back(
        "it has no cyclic synchronous torque (0x6502, bit 9) and cannot be used here");
  }
  if (facts[kWatchedFact].value_or(0) == 0) {
    drive.remarks.emplace_back("its watchdog (0x1016) is off; the daemon sets it at start-up");
  }
  if (facts[kStatusFact]) {
    const auto state = power_state(static_cast<std::uint16_t>(*facts[kStatusFact]));
    if (state == PowerState::kFault || state == PowerState::kEnabled) {
      drive.remarks.push_back(fmt::format("its state is: {}", power_state_name(*state)));
    }
  }
  drive.remarks.emplace_back(
      "the unit of its 0x606C, and on which side of the gear its encoder and "
      "rated torque are meant, stand in its manual alone");
  return drive;
}

std::vector<FoundDrive> CanopenScanner::found() const {
  std::vector<FoundDrive> drives;
  for (const Node& node : nodes_) {
    drives.push_back(describe(node));
  }
  std::sort(drives.begin(), drives.end(),
            [](const FoundDrive& a, const FoundDrive& b) { return a.id < b.id; });
  return drives;
}

}  // namespace geodesic::drivers::cia402
