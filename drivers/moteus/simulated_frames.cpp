// What a moteus drive reads from a frame and how it answers; see simulated.hpp. Written after the
// vendor's server, byte by byte and in float32, unlike the codec.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "drivers/moteus/simulated.hpp"

namespace geodesic::drivers::moteus {

namespace {

constexpr unsigned kFloatType = 3;
constexpr std::size_t kRoom = 64;
constexpr std::size_t kStreamRoom = 40;  ///< of one answer
constexpr std::int32_t kModel = 0;
constexpr std::int32_t kFirmwareVersion = 0x010100;

void put(Frame& frame, std::uint32_t byte) {
  if (frame.length < kRoom) {
    frame.data[frame.length] = static_cast<std::uint8_t>(byte);
    ++frame.length;
  }
}

void put_varuint(Frame& frame, std::uint32_t value) {
  do {
    const std::uint32_t low = value % 128U;
    value /= 128U;
    put(frame, value != 0 ? low + 128U : low);
  } while (value != 0);
}

std::int32_t lowest(unsigned type) {
  return type == 0   ? std::numeric_limits<std::int8_t>::min()
         : type == 1 ? std::numeric_limits<std::int16_t>::min()
                     : std::numeric_limits<std::int32_t>::min();
}

float unit(unsigned type, Quantity quantity) {
  const Scale& scale = kScales.at(static_cast<std::size_t>(quantity));
  return static_cast<float>(type == 0 ? scale.int8 : (type == 1 ? scale.int16 : scale.int32));
}

void put_integer(Frame& frame, unsigned type, std::int32_t value) {
  const auto raw = static_cast<std::uint32_t>(value);
  for (unsigned i = 0; i < (type == 0 ? 1U : (type == 1 ? 2U : 4U)); ++i) {
    put(frame, raw / (1U << (8U * i)) % 256U);
  }
}

}  // namespace

struct Simulated::Cursor {
  const Frame& frame;
  std::size_t at = 0;

  bool ended() const { return at >= frame.length; }

  bool varuint(std::uint32_t& value) {
    value = 0;
    std::uint64_t weight = 1;
    for (int i = 0; i < 5; ++i) {
      if (ended()) {
        return false;
      }
      const std::uint32_t byte = frame.data[at++];
      value += static_cast<std::uint32_t>(byte % 128U * weight);
      if (byte < 128U) {
        return true;
      }
      weight *= 128U;
    }
    return false;
  }

  bool value(unsigned type, Value& out) {
    const std::size_t size = type == 0 ? 1 : (type == 1 ? 2 : 4);
    if (at + size > frame.length) {
      return false;
    }
    std::uint32_t raw = 0;
    for (std::size_t i = 0; i < size; ++i) {
      raw += static_cast<std::uint32_t>(frame.data[at + i]) << (8U * i);
    }
    at += size;
    out.type = type;
    out.real = type == kFloatType ? std::bit_cast<float>(raw) : 0.0F;
    out.integer = type == 0   ? static_cast<std::int8_t>(raw)
                  : type == 1 ? static_cast<std::int16_t>(raw)
                              : static_cast<std::int32_t>(raw);
    return true;
  }
};

std::size_t Simulated::receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) {
  const std::uint32_t destination = frame.id % 256U;
  const std::uint32_t source = frame.id / 256U % 256U;
  if (frame.error || frame.remote || out.empty() || frame.id >> kPrefixShift != prefix_ ||
      (destination != id_ && destination != kBroadcast)) {
    return 0;
  }
  advance(now_ns);
  const bool wanted = source >= 128U;
  Frame reply;
  commanded_ = false;
  Cursor cursor{frame};
  while (!cursor.ended() && process(cursor, wanted ? &reply : nullptr)) {
  }
  if (commanded_) {
    apply(now_ns);
  }
  if (!wanted || reply.length == 0) {
    return 0;
  }
  reply.id = prefix_ * 65536U + id_ * 256U + source % 128U;
  reply.extended = reply.id >= 2048U;
  reply.fd = frame.fd || reply.length > 8;
  reply.bit_rate_switch = reply.fd && frame.bit_rate_switch;
  constexpr std::array<std::uint8_t, 7> kLengths = {12, 16, 20, 24, 32, 48, 64};
  if (reply.length > 8) {
    const std::uint8_t padded = *std::find_if(kLengths.begin(), kLengths.end(),
                                              [&](std::uint8_t n) { return n >= reply.length; });
    while (reply.length < padded) {
      put(reply, opcode::kNop);
    }
  }
  out[0] = reply;
  return 1;
}

/// One subframe. @return false: the rest of the frame cannot be used.
bool Simulated::process(Cursor& cursor, Frame* reply) {
  std::uint32_t code = 0;
  if (!cursor.varuint(code)) {
    return false;
  }
  if (code == opcode::kNop) {
    return true;
  }
  if (code == opcode::kClientToServer || code == opcode::kClientPoll) {
    return serve_stream(cursor, static_cast<std::uint8_t>(code), reply);
  }
  if (code < 0x10) {
    return write_group(cursor, code, reply);
  }
  return code < 0x20 && read_group(cursor, code - 0x10, reply);
}

bool Simulated::write_group(Cursor& cursor, unsigned code, Frame* reply) {
  std::uint32_t count = code % 4U;
  std::uint32_t number = 0;
  if ((count == 0 && !cursor.varuint(count)) || !cursor.varuint(number)) {
    return false;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    Value value;
    if (!cursor.value(code / 4U, value)) {
      return false;
    }
    const std::uint32_t error = write_register(number + i, value);
    if (error != 0 && reply != nullptr) {
      put(*reply, opcode::kWriteError);
      put_varuint(*reply, number + i);
      put_varuint(*reply, error);
    }
  }
  return true;
}

bool Simulated::read_group(Cursor& cursor, unsigned code, Frame* reply) {
  std::uint32_t count = code % 4U;
  std::uint32_t number = 0;
  if (reply == nullptr) {
    return true;
  }
  if ((count == 0 && !cursor.varuint(count)) || !cursor.varuint(number)) {
    return false;
  }
  const std::uint8_t start = reply->length;
  put(*reply, 0x20U + code);
  if (code % 4U == 0) {
    put_varuint(*reply, count);
  }
  put_varuint(*reply, number);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!read_register(number + i, code / 4U, *reply)) {
      std::fill(reply->data.begin() + start, reply->data.end(), std::uint8_t{0});
      reply->length = start;
      put(*reply, opcode::kReadError);
      put_varuint(*reply, number + i);
      put_varuint(*reply, kUnknownRegister);
      return false;
    }
  }
  return true;
}

bool Simulated::serve_stream(Cursor& cursor, std::uint8_t code, Frame* reply) {
  std::uint32_t channel = 0;
  std::uint32_t count = 0;
  if (!cursor.varuint(channel) || !cursor.varuint(count) || channel != kDiagnosticChannel) {
    return false;
  }
  const std::size_t had = said_size_;  // an answer is ready one request later
  if (code == opcode::kClientToServer) {
    if (cursor.at + count > cursor.frame.length) {
      return false;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const char letter = static_cast<char>(cursor.frame.data[cursor.at++]);
      if (letter == '\n') {
        obey_line({heard_.data(), heard_size_});
        heard_size_ = 0;
      } else if (heard_size_ < heard_.size()) {
        heard_[heard_size_++] = letter;
      }
    }
  }
  if (reply == nullptr) {
    return true;
  }
  const std::size_t most =
      code == opcode::kClientPoll ? std::min<std::size_t>(count, kStreamRoom) : kStreamRoom;
  const std::size_t size = std::min(had, most);
  put(*reply, opcode::kServerToClient);
  put_varuint(*reply, channel);
  put_varuint(*reply, static_cast<std::uint32_t>(size));
  for (std::size_t i = 0; i < size; ++i) {
    put(*reply, static_cast<std::uint8_t>(said_[i]));
  }
  std::copy(said_.begin() + static_cast<std::ptrdiff_t>(size),
            said_.begin() + static_cast<std::ptrdiff_t>(said_size_), said_.begin());
  said_size_ -= size;
  return true;
}

std::uint32_t Simulated::write_register(std::uint32_t number, const Value& value) {
  const auto real = [&value](Quantity quantity) {
    if (value.type == kFloatType) {
      return value.real;
    }
    return value.integer == lowest(value.type)
               ? kNone
               : static_cast<float>(value.integer) * unit(value.type, quantity);
  };
  switch (static_cast<Register>(number)) {
    case Register::kMode: {
      const float wanted =
          value.type == kFloatType ? value.real : static_cast<float>(value.integer);
      if (!(wanted >= 0.0F && wanted < static_cast<float>(kModeNames.size()))) {
        return kUnknownRegister;
      }
      command_ = {};
      command_.mode = static_cast<std::uint8_t>(wanted);
      commanded_ = true;
      return 0;
    }
    case Register::kCommandPosition:
      command_.position = real(Quantity::kPosition);
      return 0;
    case Register::kCommandVelocity:
      command_.velocity = real(Quantity::kVelocity);
      return 0;
    case Register::kCommandTorque:
      command_.torque = real(Quantity::kTorque);
      return 0;
    case Register::kCommandKpScale:
      command_.kp_scale = real(Quantity::kScale);
      return 0;
    case Register::kCommandKdScale:
      command_.kd_scale = real(Quantity::kScale);
      return 0;
    case Register::kCommandIlimitScale:
      command_.ilimit_scale = real(Quantity::kScale);
      return 0;
    case Register::kCommandMaxTorque:
      command_.max_torque = real(Quantity::kTorque);
      return 0;
    case Register::kCommandTimeout:
      command_.timeout_s = real(Quantity::kTime);
      return 0;
    case Register::kSetOutputNearest: {
      const float period = std::max(1e-4F, ram_.ratio);
      const float turns = std::round((real(Quantity::kPosition) - position()) / period);
      base_rev_ += std::isfinite(turns) ? static_cast<double>(turns * period) : 0.0;
      home_ = Home::kOutput;
      return 0;
    }
    case Register::kSetOutputExact: {
      const float shift = real(Quantity::kPosition) - position();
      base_rev_ += std::isfinite(shift) ? static_cast<double>(shift) : 0.0;
      home_ = Home::kOutput;
      return 0;
    }
    default:
      return find_register(number) == nullptr                        ? kUnknownRegister
             : number < 0x010 || (number >= 0x030 && number < 0x130) ? kNotWriteable
                                                                     : 0;
  }
}

void Simulated::put_number(Frame& reply, unsigned type, float value, Quantity quantity) const {
  if (type == kFloatType) {
    put_integer(reply, type, std::bit_cast<std::int32_t>(value));
    return;
  }
  const auto top = static_cast<float>(-(lowest(type) + 1));
  const float scaled = quantity == Quantity::kInteger ? value : value / unit(type, quantity);
  if (!std::isfinite(value)) {
    put_integer(reply, type, lowest(type));
  } else if (scaled >= top) {
    put_integer(reply, type, -(lowest(type) + 1));
  } else {
    put_integer(reply, type, static_cast<std::int32_t>(std::max(scaled, -top)));
  }
}

bool Simulated::read_register(std::uint32_t number, unsigned type, Frame& reply) const {
  const auto put = [&](float value, Quantity quantity) {
    put_number(reply, type, value, quantity);
    return true;
  };
  switch (static_cast<Register>(number)) {
    case Register::kMode:
      return put(mode_, Quantity::kInteger);
    case Register::kPosition:
      return put(position(), Quantity::kPosition);
    case Register::kVelocity:
      return put(static_cast<float>(shaft_rev_s_), Quantity::kVelocity);
    case Register::kTorque:
      return put(made_torque(), Quantity::kTorque);
    case Register::kQCurrent:
      return put(0.0F, Quantity::kCurrent);
    case Register::kTrajectoryComplete:
      return put(1.0F, Quantity::kInteger);
    case Register::kHomeState:
      return put(static_cast<float>(home_), Quantity::kInteger);
    case Register::kVoltage:
      return put(24.0F, Quantity::kVoltage);
    case Register::kTemperature:
    case Register::kMotorTemperature:
      return put(celsius_, Quantity::kTemperature);
    case Register::kFault:
      return put(fault_, Quantity::kInteger);
    case Register::kCommandPosition:
      return put(command_.position, Quantity::kPosition);
    case Register::kCommandVelocity:
      return put(command_.velocity, Quantity::kVelocity);
    case Register::kCommandTorque:
      return put(command_.torque, Quantity::kTorque);
    case Register::kCommandKpScale:
      return put(command_.kp_scale, Quantity::kScale);
    case Register::kCommandKdScale:
      return put(command_.kd_scale, Quantity::kScale);
    case Register::kCommandMaxTorque:
      return put(command_.max_torque, Quantity::kTorque);
    case Register::kCommandTimeout:
      return put(command_.timeout_s, Quantity::kTime);
    case Register::kCommandIlimitScale:
      return put(command_.ilimit_scale, Quantity::kScale);
    case Register::kModel:
    case Register::kFirmware:
    case Register::kRegisterMap:
      if (type != 2) {
        return false;
      }
      put_integer(reply, type,
                  number == 0x100 ? kModel : (number == 0x101 ? kFirmwareVersion : map_));
      return true;
    default:
      return false;
  }
}

}  // namespace geodesic::drivers::moteus
