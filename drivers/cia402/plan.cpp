// The list of transfers of a start-up; see plan.hpp. Sources: README.md.
#include "drivers/cia402/plan.hpp"

#include <span>

namespace geodesic::drivers::cia402 {

namespace {

using Compare = Transfer::Compare;
using Kind = Transfer::Kind;

constexpr const char* kNotTaken = "the drive does not take what it is told: check its firmware";

/// PDO n of the objects of PDO 1.
constexpr Object of_pdo(Object object, unsigned pdo) noexcept {
  object.index = static_cast<std::uint16_t>(object.index + pdo - 1U);
  return object;
}

class Writer {
 public:
  Writer(const DriveOptions& options, const Units& units) : options_(options), units_(units) {}

  Plan write() noexcept {
    identity();
    figures();
    plan_.figures_end = plan_.count;
    supervision();
    process_data();
    mode();
    return plan_;
  }

 private:
  void add(const Transfer& transfer) noexcept {
    if (plan_.count < Plan::kMost) {
      plan_.transfers[plan_.count++] = transfer;
    }
  }

  void read(Object object, std::uint32_t value, const char* quantity, const char* fix,
            bool may_lack = false) noexcept {
    add({.kind = Kind::kRead,
         .object = object,
         .value = value,
         .may_lack = may_lack,
         .quantity = quantity,
         .fix = fix});
  }

  void tell(Object object, std::uint32_t value, const char* quantity,
            bool may_lack = false) noexcept {
    add({.kind = Kind::kWrite,
         .object = object,
         .value = value,
         .may_lack = may_lack,
         .quantity = quantity});
  }

  /// Written and read back.
  void set(Object object, std::uint32_t value, const char* quantity,
           bool may_lack = false) noexcept {
    add({.kind = Kind::kWrite,
         .object = object,
         .value = value,
         .may_lack = may_lack,
         .skipped_if_lacking = 1,
         .quantity = quantity});
    read(object, value, quantity, kNotTaken);
  }

  void identity() noexcept {
    add({.kind = Kind::kRead,
         .object = object::kDeviceType,
         .value = kDeviceProfile,
         .mask = 0xFFFF,
         .quantity = "device type (0x1000:0, low half)",
         .fix = "this node is no CiA 402 drive: check the drive's id in the robot file"});
    const auto identify = [this](Object object, Setting setting, Compare compare,
                                 const char* quantity, const char* fix) {
      const std::uint32_t wanted = integer(options_, setting);
      add({.kind = Kind::kRead,
           .object = object,
           .value = wanted,
           .compare = wanted == 0 ? Compare::kAny : compare,
           .may_lack = wanted == 0,
           .quantity = quantity,
           .fix = fix});
    };
    identify(object::kVendor, Setting::kVendor, Compare::kEqual, "vendor (0x1018:1)",
             "another maker's drive: correct vendor_id in the robot file, or exchange the drive");
    identify(object::kProduct, Setting::kProduct, Compare::kEqual, "product code (0x1018:2)",
             "another model: correct product_code in the robot file, or exchange the drive");
    identify(object::kRevision, Setting::kLeastRevision, Compare::kAtLeast, "revision (0x1018:3)",
             "the drive's firmware is too old: update it");
    add({.kind = Kind::kRead,
         .object = object::kSupportedModes,
         .value = kCyclicTorqueBit,
         .compare = Compare::kAllBits,
         .mask = kCyclicTorqueBit,
         .quantity = "cyclic synchronous torque among the supported modes (0x6502:0, bit 9)",
         .fix = "the drive has no cyclic synchronous torque: update its firmware, or choose "
                "another drive"});
  }

  void figures() noexcept {
    if (choice<Check>(options_, Setting::kRatedTorqueCheck) == Check::kDrive) {
      read(object::kRatedTorque, integer(options_, Setting::kRatedTorque),
           "rated torque (0x6076:0) [mN·m]",
           "correct rated_torque_mnm in the robot file, or the drive's motor data");
    }
    if (choice<Check>(options_, Setting::kEncoderCheck) == Check::kDrive) {
      const std::uint32_t revolutions = integer(options_, Setting::kEncoderRevolutions);
      read(object::kEncoderIncrements, integer(options_, Setting::kEncoderIncrements),
           "encoder increments (0x608F:1)",
           "correct encoder_increments in the robot file, or the drive's encoder data");
      read(object::kEncoderRevolutions, revolutions, "encoder revolutions (0x608F:2)",
           "correct encoder_revolutions in the robot file, or the drive's encoder data",
           revolutions == 1);
    }
    if (choice<Check>(options_, Setting::kGearCheck) == Check::kDrive) {
      const std::uint32_t motor = integer(options_, Setting::kGearMotor);
      const std::uint32_t shaft = integer(options_, Setting::kGearShaft);
      const bool direct = motor == 1 && shaft == 1;
      read(object::kGearMotor, motor, "gear: motor revolutions (0x6091:1)",
           "correct gear_motor_revolutions in the robot file, or the drive's gear data; if its "
           "0x6091 is no more than a factor, say gear_check = \"manual\"",
           direct);
      read(object::kGearShaft, shaft, "gear: shaft revolutions (0x6091:2)",
           "correct gear_shaft_revolutions in the robot file, or the drive's gear data; if its "
           "0x6091 is no more than a factor, say gear_check = \"manual\"",
           direct);
    }
  }

  void supervision() noexcept {
    set(object::kProducerHeartbeat, integer(options_, Setting::kHeartbeat),
        "its own heartbeat (0x1017:0) [ms]");
    set(object::kConsumerHeartbeat,
        integer(options_, Setting::kHostNode) << 16U | units_.watchdog_ms,
        "heartbeat it watches (0x1016:1) [node << 16 | ms]");
    const auto lost = choice<ConnectionLost>(options_, Setting::kConnectionLost);
    set(object::kAbortConnection, static_cast<std::uint32_t>(lost) + 1U,
        "reaction to a lost connection (0x6007:0)");
    const auto stop = choice<QuickStop>(options_, Setting::kQuickStop);
    if (stop != QuickStop::kAsItIs) {
      set(object::kQuickStop, static_cast<std::uint32_t>(stop), "quick stop option (0x605A:0)");
    }
    set(object::kMaxTorque, units_.max_torque_permille, "maximum torque (0x6072:0) [per mille]");
  }

  void map(Object count, std::span<const Object> mapped, const char* entries,
           const char* number) noexcept {
    tell(count, 0, number);
    for (std::size_t i = 0; i < mapped.size(); ++i) {
      const Object& one = mapped[i];
      tell({count.index, static_cast<std::uint8_t>(i + 1), 4},
           static_cast<std::uint32_t>(one.index) << 16U |
               static_cast<std::uint32_t>(one.sub) << 8U | one.bytes * 8U,
           entries);
    }
    set(count, static_cast<std::uint32_t>(mapped.size()), number);
  }

  void process_data() noexcept {
    const std::uint32_t node = options_.id;
    constexpr const char* kId1 = "identifier of TPDO1 (0x1800:1)";
    tell(object::kTransmitId, cob::kInvalid | (cob::kTransmit1 + node), kId1);
    tell(object::kTransmitType, kTypeEverySync, "transmission type of TPDO1 (0x1800:2)");
    map(object::kTransmitCount, kMapTransmit1, "mapping of TPDO1 (0x1A00:1 to 3)",
        "number of objects in TPDO1 (0x1A00:0)");
    set(object::kTransmitId, cob::kTransmit1 + node, kId1);

    constexpr const char* kId2 = "identifier of TPDO2 (0x1801:1)";
    const Object second = of_pdo(object::kTransmitId, 2);
    const bool velocity = units_.rad_s_per_velocity > 0.0;
    tell(second, cob::kInvalid | (cob::kTransmit2 + node), kId2, !velocity);
    if (velocity) {
      tell(of_pdo(object::kTransmitType, 2), kTypeEverySync,
           "transmission type of TPDO2 (0x1801:2)");
      map(of_pdo(object::kTransmitCount, 2), kMapTransmit2, "mapping of TPDO2 (0x1A01:1)",
          "number of objects in TPDO2 (0x1A01:0)");
      set(second, cob::kTransmit2 + node, kId2);
    }
    silence(object::kTransmitId, cob::kTransmit1, 3, "identifier of TPDO3 (0x1802:1)");
    silence(object::kTransmitId, cob::kTransmit1, 4, "identifier of TPDO4 (0x1803:1)");

    constexpr const char* kIdReceive = "identifier of RPDO1 (0x1400:1)";
    tell(object::kReceiveId, cob::kInvalid | (cob::kReceive1 + node), kIdReceive);
    const auto type = choice<ReceiveType>(options_, Setting::kReceiveType);
    tell(object::kReceiveType, type == ReceiveType::kSync ? kTypeEverySync : kTypeAtOnce,
         "transmission type of RPDO1 (0x1400:2)");
    const auto timer = choice<ReceiveTimer>(options_, Setting::kReceiveTimer);
    if (timer != ReceiveTimer::kOff) {
      set(object::kReceiveTimer, units_.watchdog_ms, "deadline for torque frames (0x1400:5) [ms]",
          timer == ReceiveTimer::kIfThere);
    }
    map(object::kReceiveCount, kMapReceive1, "mapping of RPDO1 (0x1600:1 and 2)",
        "number of objects in RPDO1 (0x1600:0)");
    set(object::kReceiveId, cob::kReceive1 + node, kIdReceive);
    silence(object::kReceiveId, cob::kReceive1, 2, "identifier of RPDO2 (0x1401:1)");
    silence(object::kReceiveId, cob::kReceive1, 3, "identifier of RPDO3 (0x1402:1)");
    silence(object::kReceiveId, cob::kReceive1, 4, "identifier of RPDO4 (0x1403:1)");
  }

  /// PDOs we do not use are switched off, where the drive has them: makers map them by event.
  void silence(Object id, std::uint32_t first, unsigned pdo, const char* quantity) noexcept {
    tell(of_pdo(id, pdo), cob::kInvalid | (first + cob::kStep * (pdo - 1U) + options_.id), quantity,
         true);
  }

  void mode() noexcept {
    const auto torque = static_cast<std::uint32_t>(kCyclicTorque);
    tell(object::kMode, torque, "mode of operation (0x6060:0)");
    add({.kind = Kind::kAwait,
         .object = object::kModeDisplay,
         .value = torque,
         .quantity = "mode of operation in force (0x6061:0)",
         .fix = "the drive does not take cyclic synchronous torque: check its firmware and state"});
  }

  const DriveOptions& options_;
  const Units& units_;
  Plan plan_;
};

}  // namespace

Plan make_plan(const DriveOptions& options, const Units& units) noexcept {
  return Writer(options, units).write();
}

}  // namespace geodesic::drivers::cia402
