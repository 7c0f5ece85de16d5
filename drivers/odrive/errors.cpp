// Names of errors, axis states and procedure results; sources: README.md.
#include "drivers/odrive/errors.hpp"

#include <array>

namespace geodesic::drivers::odrive {

namespace {

struct Name {
  std::uint8_t code;
  const char* text;
};

constexpr std::uint8_t at(std::uint8_t base, unsigned bit) {
  return static_cast<std::uint8_t>(base + bit);
}

constexpr std::array kNames = {
    Name{at(kActiveBase, 0), "initialising"},
    Name{at(kActiveBase, 1), "system level error"},
    Name{at(kActiveBase, 2), "timing error"},
    Name{at(kActiveBase, 3), "missing estimate (encoder not calibrated or not found)"},
    Name{at(kActiveBase, 4), "bad configuration"},
    Name{at(kActiveBase, 5), "gate driver fault"},
    Name{at(kActiveBase, 6), "missing input"},
    Name{at(kActiveBase, 8), "bus over-voltage"},
    Name{at(kActiveBase, 9), "bus under-voltage"},
    Name{at(kActiveBase, 10), "bus over-current"},
    Name{at(kActiveBase, 11), "bus regenerative over-current"},
    Name{at(kActiveBase, 12), "current limit violation"},
    Name{at(kActiveBase, 13), "motor over-temperature"},
    Name{at(kActiveBase, 14), "inverter over-temperature"},
    Name{at(kActiveBase, 15), "velocity limit violation"},
    Name{at(kActiveBase, 16), "position limit violation"},
    Name{at(kActiveBase, 24), "watchdog expired"},
    Name{at(kActiveBase, 25), "emergency stop requested"},
    Name{at(kActiveBase, 26), "spin-out detected"},
    Name{at(kActiveBase, 27), "brake resistor disarmed"},
    Name{at(kActiveBase, 28), "thermistor disconnected"},
    Name{at(kActiveBase, 30), "calibration error"},
    Name{at(kAxisBase, 0), "invalid axis state"},
    Name{at(kAxisBase, 6), "motor failed"},
    Name{at(kAxisBase, 7), "sensorless estimator failed"},
    Name{at(kAxisBase, 8), "encoder failed"},
    Name{at(kAxisBase, 9), "controller failed"},
    Name{at(kAxisBase, 11), "watchdog expired"},
    Name{at(kAxisBase, 12), "lower end stop pressed"},
    Name{at(kAxisBase, 13), "upper end stop pressed"},
    Name{at(kAxisBase, 14), "emergency stop requested"},
    Name{at(kAxisBase, 17), "homing without end stop"},
    Name{at(kAxisBase, 18), "over-temperature"},
    Name{at(kAxisBase, 19), "position unknown"},
    Name{at(kEncoderBase, 0), "encoder: unstable gain"},
    Name{at(kEncoderBase, 1), "encoder: counts do not fit the pole pairs"},
    Name{at(kEncoderBase, 2), "encoder: no response"},
    Name{at(kEncoderBase, 3), "encoder: unsupported mode"},
    Name{at(kEncoderBase, 4), "encoder: illegal hall state"},
    Name{at(kEncoderBase, 5), "encoder: index not found"},
    Name{at(kEncoderBase, 6), "encoder: absolute SPI time-out"},
    Name{at(kEncoderBase, 7), "encoder: absolute SPI communication failed"},
    Name{at(kEncoderBase, 8), "encoder: absolute SPI not ready"},
    Name{at(kEncoderBase, 9), "encoder: hall not calibrated"},
    Name{at(kControllerBase, 0), "controller: overspeed"},
    Name{at(kControllerBase, 1), "controller: invalid input mode"},
    Name{at(kControllerBase, 2), "controller: unstable gain"},
    Name{at(kControllerBase, 3), "controller: invalid mirror axis"},
    Name{at(kControllerBase, 4), "controller: invalid load encoder"},
    Name{at(kControllerBase, 5), "controller: invalid estimate"},
    Name{at(kControllerBase, 6), "controller: invalid circular range"},
    Name{at(kControllerBase, 7), "controller: spin-out detected"},
    Name{at(kMotorBase, 0), "motor: phase resistance out of range"},
    Name{at(kMotorBase, 1), "motor: phase inductance out of range"},
    Name{at(kMotorBase, 3), "motor: gate driver fault"},
    Name{at(kMotorBase, 4), "motor: control deadline missed"},
    Name{at(kMotorBase, 7), "motor: modulation magnitude"},
    Name{at(kMotorBase, 10), "motor: current sense saturation"},
    Name{at(kMotorBase, 12), "motor: current limit violation"},
    Name{at(kMotorBase, 16), "motor: modulation is no number"},
    Name{at(kMotorBase, 17), "motor: motor over-temperature"},
    Name{at(kMotorBase, 18), "motor: inverter over-temperature"},
    Name{at(kMotorBase, 19), "motor: timer update missed"},
    Name{at(kMotorBase, 20), "motor: current measurement unavailable"},
    Name{at(kMotorBase, 21), "motor: controller failed"},
    Name{at(kMotorBase, 22), "motor: bus current out of range"},
    Name{at(kMotorBase, 23), "motor: brake resistor disarmed"},
    Name{at(kMotorBase, 24), "motor: system level error"},
    Name{at(kMotorBase, 25), "motor: bad timing"},
    Name{at(kMotorBase, 26), "motor: phase estimate unknown"},
    Name{at(kMotorBase, 27), "motor: phase velocity unknown"},
    Name{at(kMotorBase, 28), "motor: torque unknown"},
    Name{at(kMotorBase, 29), "motor: current command unknown"},
    Name{at(kMotorBase, 30), "motor: current measurement unknown"},
    Name{at(kMotorBase, 31), "motor: bus voltage unknown"},
    Name{at(kMotorBase, 32), "motor: voltage command unknown"},
    Name{at(kMotorBase, 33), "motor: gains unknown"},
    Name{at(kMotorBase, 34), "motor: controller initialising"},
    Name{at(kMotorBase, 35), "motor: unbalanced phases"},
    Name{kHeartbeatLost, "no heartbeat"},
};

constexpr std::array kStates = {
    "undefined",         "idle",
    "start-up sequence", "full calibration",
    "motor calibration", "sensorless control",
    "index search",      "encoder offset calibration",
    "closed loop",       "lock-in spin",
    "encoder direction", "homing",
    "hall polarity",     "hall phase",
    "anticogging",
};

constexpr std::array kResults = {
    "success",
    "busy",
    "cancelled",
    "disarmed",
    "no response",
    "pole pairs do not fit the counts",
    "phase resistance out of range",
    "phase inductance out of range",
    "unbalanced phases",
    "invalid motor type",
    "illegal hall state",
    "time-out",
    "homing without end stop",
    "invalid state",
    "not calibrated",
    "not converging",
};

}  // namespace

const char* error_name(std::uint8_t code) {
  for (const Name& name : kNames) {
    if (name.code == code) {
      return name.text;
    }
  }
  return "unknown error";
}

const char* state_name(std::uint8_t state) {
  return state < kStates.size() ? kStates[state] : "unknown state";
}

const char* result_name(std::uint8_t result) {
  return result < kResults.size() ? kResults[result] : "unknown result";
}

}  // namespace geodesic::drivers::odrive
