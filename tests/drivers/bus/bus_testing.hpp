// What the tests of the buses share: frames to send, waiting for frames.
#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "rt/clock.hpp"

namespace geodesic::drivers::testing {

constexpr std::int64_t kMillisecond = 1'000'000;
/// Long enough for a busy machine; tests end as soon as they have what they wait for.
constexpr std::int64_t kPatienceNs = 5'000 * kMillisecond;

inline Frame make_frame(std::uint32_t id, std::initializer_list<int> data = {}) {
  Frame frame;
  frame.id = id;
  for (const int byte : data) {
    frame.data[frame.length++] = static_cast<std::uint8_t>(byte);
  }
  return frame;
}

inline Frame make_fd_frame(std::uint32_t id, std::uint8_t length) {
  Frame frame = make_frame(id);
  frame.fd = true;
  frame.bit_rate_switch = true;
  frame.length = length;
  for (std::uint8_t i = 0; i < length; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(id + i);
  }
  return frame;
}

/// One frame for each identifier, all marked with the cycle they belong to.
inline std::vector<Frame> make_cycle(std::uint32_t first_id, std::size_t count, int cycle) {
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < count; ++i) {
    frames.push_back(make_frame(first_id + static_cast<std::uint32_t>(i), {cycle, 0, 0, 0}));
  }
  return frames;
}

inline std::vector<IdFilter> ids(std::uint32_t first, std::size_t count) {
  std::vector<IdFilter> list;
  for (std::size_t i = 0; i < count; ++i) {
    list.push_back({.id = first + static_cast<std::uint32_t>(i)});
  }
  return list;
}

/// Reads until `count` frames are there or patience ends.
inline std::vector<ReceivedFrame> receive(Bus& bus, std::size_t count,
                                          std::int64_t patience_ns = kPatienceNs) {
  std::vector<ReceivedFrame> frames;
  const std::int64_t end = rt::now_ns() + patience_ns;
  std::array<ReceivedFrame, 32> batch;
  while (frames.size() < count && rt::now_ns() < end) {
    pollfd polled{.fd = bus.descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&polled, 1, 10);
    const std::size_t n = bus.receive(batch);
    frames.insert(frames.end(), batch.begin(), batch.begin() + static_cast<long>(n));
  }
  return frames;
}

inline std::vector<ReceivedFrame> receive_for(Bus& bus, std::int64_t duration_ns) {
  return receive(bus, static_cast<std::size_t>(-1), duration_ns);
}

/// Repeats until it holds or patience ends.
inline bool eventually(const std::function<bool()>& holds) {
  const std::int64_t end = rt::now_ns() + kPatienceNs;
  while (rt::now_ns() < end) {
    if (holds()) {
      return true;
    }
    ::usleep(1000);
  }
  return holds();
}

/// Sends again and again, as a cycle does, until the bus takes it.
inline bool send_when_free(Bus& bus, std::span<const Frame> frames) {
  return eventually([&] { return bus.send(frames) == frames.size(); });
}

inline std::string error_text(const std::function<void()>& action) {
  try {
    action();
  } catch (const BusError& error) {
    return error.what();
  }
  return "";
}

}  // namespace geodesic::drivers::testing
