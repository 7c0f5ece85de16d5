// Where things stand in each CANSimple message, of either firmware. Facts only; sources: README.md.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/odrive/layout.hpp"

namespace geodesic::drivers::odrive {

// Reports.
inline constexpr Message kVersionReport{Command::kVersion,
                                        "Get_Version",
                                        true,
                                        true,
                                        false,
                                        8,
                                        {{{"Protocol_Version", "", 0, Type::kU8},
                                          {"Hw_Version_Major", "", 8, Type::kU8},
                                          {"Hw_Version_Minor", "", 16, Type::kU8},
                                          {"Hw_Version_Variant", "", 24, Type::kU8},
                                          {"Fw_Version_Major", "", 32, Type::kU8},
                                          {"Fw_Version_Minor", "", 40, Type::kU8},
                                          {"Fw_Version_Revision", "", 48, Type::kU8},
                                          {"Fw_Version_Unreleased", "", 56, Type::kU8}}}};
inline constexpr Message kHeartbeat06{Command::kHeartbeat,
                                      "Heartbeat",
                                      true,
                                      true,
                                      false,
                                      8,
                                      {{{"Axis_Error", "", 0, Type::kU32},
                                        {"Axis_State", "", 32, Type::kU8},
                                        {"Procedure_Result", "", 40, Type::kU8},
                                        {"Trajectory_Done_Flag", "", 48, Type::kFlag}}}};
inline constexpr Message kHeartbeat05{Command::kHeartbeat,
                                      "Heartbeat",
                                      true,
                                      false,
                                      true,
                                      8,
                                      {{{"Axis_Error", "", 0, Type::kU32},
                                        {"Axis_State", "", 32, Type::kU8},
                                        {"Motor_Error_Flag", "", 40, Type::kFlag},
                                        {"Encoder_Error_Flag", "", 48, Type::kFlag},
                                        {"Controller_Error_Flag", "", 56, Type::kFlag},
                                        {"Trajectory_Done_Flag", "", 63, Type::kFlag}}}};
inline constexpr Message kError06{
    Command::kError,
    "Get_Error",
    true,
    true,
    false,
    8,
    {{{"Active_Errors", "", 0, Type::kU32}, {"Disarm_Reason", "", 32, Type::kU32}}}};
inline constexpr Message kMotorError05{Command::kError,
                                       "Get_Motor_Error",
                                       true,
                                       false,
                                       true,
                                       8,
                                       {{{"Motor_Error", "", 0, Type::kU64}}}};
inline constexpr Message kEncoderError05{Command::kRxSdo,
                                         "Get_Encoder_Error",
                                         true,
                                         false,
                                         true,
                                         8,
                                         {{{"Encoder_Error", "", 0, Type::kU32}}}};
inline constexpr Message kSensorlessError05{Command::kTxSdo,
                                            "Get_Sensorless_Error",
                                            true,
                                            false,
                                            true,
                                            8,
                                            {{{"Sensorless_Error", "", 0, Type::kU32}}}};
inline constexpr Message kControllerError05{Command::kPowers,
                                            "Get_Controller_Error",
                                            true,
                                            false,
                                            true,
                                            8,
                                            {{{"Controller_Error", "", 0, Type::kU32}}}};
inline constexpr Message kAddressReport{Command::kAddress,
                                        "Address",
                                        true,
                                        true,
                                        false,
                                        8,
                                        {{{"Node_ID", "", 0, Type::kU8},
                                          {"Serial_Number", "", 8, Type::kU48},
                                          {"Connection_ID", "", 56, Type::kU8}}}};
inline constexpr Message kEstimates{
    Command::kEstimates,
    "Get_Encoder_Estimates",
    true,
    true,
    true,
    8,
    {{{"Pos_Estimate", "rev", 0, Type::kF32}, {"Vel_Estimate", "rev/s", 32, Type::kF32}}}};
inline constexpr Message kEncoderCount05{
    Command::kEncoderCount,
    "Get_Encoder_Count",
    true,
    false,
    true,
    8,
    {{{"Shadow_Count", "", 0, Type::kI32}, {"Count_in_CPR", "", 32, Type::kI32}}}};
inline constexpr Message kIqReport{
    Command::kIq,
    "Get_Iq",
    true,
    true,
    true,
    8,
    {{{"Iq_Setpoint", "A", 0, Type::kF32}, {"Iq_Measured", "A", 32, Type::kF32}}}};
inline constexpr Message kTemperature06{
    Command::kTemperature,
    "Get_Temperature",
    true,
    true,
    false,
    8,
    {{{"FET_Temperature", "°C", 0, Type::kF32}, {"Motor_Temperature", "°C", 32, Type::kF32}}}};
inline constexpr Message kBus{
    Command::kBus,
    "Get_Bus_Voltage_Current",
    true,
    true,
    true,
    8,
    {{{"Bus_Voltage", "V", 0, Type::kF32}, {"Bus_Current", "A", 32, Type::kF32}}}};
inline constexpr Message kTorques06{
    Command::kTorques,
    "Get_Torques",
    true,
    true,
    false,
    8,
    {{{"Torque_Target", "N·m", 0, Type::kF32}, {"Torque_Estimate", "N·m", 32, Type::kF32}}}};
inline constexpr Message kPowers06{
    Command::kPowers,
    "Get_Powers",
    true,
    true,
    false,
    8,
    {{{"Electrical_Power", "W", 0, Type::kF32}, {"Mechanical_Power", "W", 32, Type::kF32}}}};
/// Value: up to 4 bytes, of the endpoint's own type; floats on the whole.
inline constexpr Message kTxSdo06{
    Command::kTxSdo,
    "TxSdo",
    true,
    true,
    false,
    8,
    {{{"endpoint", "", 8, Type::kU16}, {"value", "", 32, Type::kF32}}}};

// Commands.
inline constexpr Message kRxSdo06{Command::kRxSdo,
                                  "RxSdo",
                                  false,
                                  true,
                                  false,
                                  8,
                                  {{{"opcode", "", 0, Type::kU8},
                                    {"endpoint", "", 8, Type::kU16},
                                    {"value", "", 32, Type::kF32}}}};
inline constexpr Message kEstop{Command::kEstop, "Estop", false, true, true, 0};
inline constexpr Message kSetNodeId05{Command::kAddress,
                                      "Set_Axis_Node_ID",
                                      false,
                                      false,
                                      true,
                                      4,
                                      {{{"Axis_Node_ID", "", 0, Type::kU32}}}};
inline constexpr Message kSetAxisState{Command::kAxisState,
                                       "Set_Axis_State",
                                       false,
                                       true,
                                       true,
                                       4,
                                       {{{"Axis_Requested_State", "", 0, Type::kU32}}}};
inline constexpr Message kSetControllerMode{
    Command::kControllerMode,
    "Set_Controller_Mode",
    false,
    true,
    true,
    8,
    {{{"Control_Mode", "", 0, Type::kU32}, {"Input_Mode", "", 32, Type::kU32}}}};
inline constexpr Message kSetInputPosition{Command::kInputPosition,
                                           "Set_Input_Pos",
                                           false,
                                           true,
                                           true,
                                           8,
                                           {{{"Input_Pos", "rev", 0, Type::kF32},
                                             {"Vel_FF", "rev/s", 32, Type::kI16Milli},
                                             {"Torque_FF", "N·m", 48, Type::kI16Milli}}}};
inline constexpr Message kSetInputVelocity{
    Command::kInputVelocity,
    "Set_Input_Vel",
    false,
    true,
    true,
    8,
    {{{"Input_Vel", "rev/s", 0, Type::kF32}, {"Input_Torque_FF", "N·m", 32, Type::kF32}}}};
inline constexpr Message kSetInputTorque{Command::kInputTorque,
                                         "Set_Input_Torque",
                                         false,
                                         true,
                                         true,
                                         4,
                                         {{{"Input_Torque", "N·m", 0, Type::kF32}}}};
inline constexpr Message kSetLimits{
    Command::kLimits,
    "Set_Limits",
    false,
    true,
    true,
    8,
    {{{"Velocity_Limit", "rev/s", 0, Type::kF32}, {"Current_Limit", "A", 32, Type::kF32}}}};
inline constexpr Message kStartAnticogging05{
    Command::kAnticogging, "Start_Anticogging", false, false, true, 0};
inline constexpr Message kSetTrajectoryVelocity{Command::kTrajectoryVelocity,
                                                "Set_Traj_Vel_Limit",
                                                false,
                                                true,
                                                true,
                                                4,
                                                {{{"Traj_Vel_Limit", "rev/s", 0, Type::kF32}}}};
inline constexpr Message kSetTrajectoryAcceleration{
    Command::kTrajectoryAcceleration,
    "Set_Traj_Accel_Limits",
    false,
    true,
    true,
    8,
    {{{"Traj_Accel_Limit", "rev/s²", 0, Type::kF32},
      {"Traj_Decel_Limit", "rev/s²", 32, Type::kF32}}}};
inline constexpr Message kSetTrajectoryInertia{Command::kTrajectoryInertia,
                                               "Set_Traj_Inertia",
                                               false,
                                               true,
                                               true,
                                               4,
                                               {{{"Traj_Inertia", "N·m·s²/rev", 0, Type::kF32}}}};
inline constexpr Message kReboot06{
    Command::kReboot, "Reboot", false, true, false, 1, {{{"Action", "", 0, Type::kU8}}}};
inline constexpr Message kReboot05{Command::kReboot, "Reboot", false, false, true, 0};
inline constexpr Message kClearErrors06{Command::kClearErrors,
                                        "Clear_Errors",
                                        false,
                                        true,
                                        false,
                                        1,
                                        {{{"Identify", "", 0, Type::kU8}}}};
inline constexpr Message kClearErrors05{
    Command::kClearErrors, "Clear_Errors", false, false, true, 0};
inline constexpr Message kSetAbsolutePosition06{Command::kAbsolutePosition,
                                                "Set_Absolute_Position",
                                                false,
                                                true,
                                                false,
                                                4,
                                                {{{"Position", "rev", 0, Type::kF32}}}};
inline constexpr Message kSetLinearCount05{Command::kAbsolutePosition,
                                           "Set_Linear_Count",
                                           false,
                                           false,
                                           true,
                                           4,
                                           {{{"Position", "counts", 0, Type::kI32}}}};
inline constexpr Message kSetPositionGain{Command::kPositionGain,
                                          "Set_Pos_Gain",
                                          false,
                                          true,
                                          true,
                                          4,
                                          {{{"Pos_Gain", "1/s", 0, Type::kF32}}}};
inline constexpr Message kSetVelocityGains{Command::kVelocityGains,
                                           "Set_Vel_Gains",
                                           false,
                                           true,
                                           true,
                                           8,
                                           {{{"Vel_Gain", "N·m·s/rev", 0, Type::kF32},
                                             {"Vel_Integrator_Gain", "N·m/rev", 32, Type::kF32}}}};
inline constexpr Message kEnterDfu06{Command::kDfu, "Enter_DFU_Mode", false, true, false, 0};

inline constexpr std::array kMessages = {
    &kVersionReport,
    &kHeartbeat06,
    &kHeartbeat05,
    &kError06,
    &kMotorError05,
    &kEncoderError05,
    &kSensorlessError05,
    &kControllerError05,
    &kAddressReport,
    &kEstimates,
    &kEncoderCount05,
    &kIqReport,
    &kTemperature06,
    &kBus,
    &kTorques06,
    &kPowers06,
    &kTxSdo06,
    &kRxSdo06,
    &kEstop,
    &kSetNodeId05,
    &kSetAxisState,
    &kSetControllerMode,
    &kSetInputPosition,
    &kSetInputVelocity,
    &kSetInputTorque,
    &kSetLimits,
    &kStartAnticogging05,
    &kSetTrajectoryVelocity,
    &kSetTrajectoryAcceleration,
    &kSetTrajectoryInertia,
    &kReboot06,
    &kReboot05,
    &kClearErrors06,
    &kClearErrors05,
    &kSetAbsolutePosition06,
    &kSetLinearCount05,
    &kSetPositionGain,
    &kSetVelocityGains,
    &kEnterDfu06,
};

/// The message of that command in that firmware; null if there is none.
constexpr const Message* find_message(Firmware firmware, std::uint32_t command) noexcept {
  for (const Message* message : kMessages) {
    if (message->in(firmware) && static_cast<std::uint32_t>(message->command) == command) {
      return message;
    }
  }
  return nullptr;
}

}  // namespace geodesic::drivers::odrive
