// How a CAN controller feels: its state, error counters and what was done for its bus. Values
// alone.
#pragma once

#include <cstdint>
#include <string>

namespace geodesic::drivers {

/// Bosch CAN 2.0 section 8, as the kernel has them (enum can_state).
enum class ControllerState : std::uint8_t {
  kUnknown,  ///< nobody said: a virtual interface, a socket bus
  kActive,   ///< both error counters below 96
  kWarning,  ///< one from 96 on
  kPassive,  ///< one from 128 on: it may no longer disturb others, and they no longer hear it say
             ///< so
  kBusOff,   ///< the transmit counter reached 256: it has left the bus
  kStopped,  ///< the interface is down, or it sleeps
};

/// "error-active", "error-warning", "error-passive", "bus-off", "stopped"; "" if unknown.
const char* to_string(ControllerState state) noexcept;

/// Not real-time.
struct LinkHealth {
  ControllerState state = ControllerState::kUnknown;
  std::uint16_t transmit_errors = 0;  ///< TEC; 0 too where the controller does not tell
  std::uint16_t receive_errors = 0;   ///< REC
  std::uint32_t bus_errors = 0;       ///< since the interface was made, as all that follow
  std::uint32_t warnings = 0;         ///< times it became error-warning
  std::uint32_t passives = 0;         ///< times it became error-passive
  std::uint32_t bus_offs = 0;         ///< times it left the bus
  std::uint32_t arbitration_lost = 0;
  std::uint32_t restarts = 0;
  // What is not the kernel's:
  std::string device;              ///< the interface's name at present; empty: gone, or none
  std::uint64_t purged = 0;        ///< times the queue was emptied since the bus was held
  std::uint64_t reopened = 0;      ///< times the interface came back
  double foreign_frames_hz = 0.0;  ///< frames a second that are nobody's of this robot
};

/// What the keeper of a bus has to tell, for the log.
struct BusNews {
  bool warning = false;
  std::string text;
};

}  // namespace geodesic::drivers
