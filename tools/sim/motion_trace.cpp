// The true motion of the simulated arm as a CSV file; see the header.
#include "tools/sim/motion_trace.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <stdexcept>

namespace geodesic::tools {

MotionTrace::MotionTrace(const std::filesystem::path& file, const Plant& plant)
    : file_(std::fopen(file.c_str(), "w")) {
  if (!file_) {
    throw std::runtime_error(
        fmt::format("cannot write the trace to {}: {}", file.string(), std::strerror(errno)));
  }
  std::string line = "time_s,released";
  for (const JointHistory& joint : plant.report().joints) {
    line += fmt::format(",q_{0},v_{0},torque_{0}", joint.name);
  }
  fmt::print(file_.get(), "{}\n", line);
}

MotionTrace::~MotionTrace() {
  flush_before(0.0);
}

void MotionTrace::flush_before(double release_s) {
  for (const auto& [time_s, rest] : before_) {
    fmt::print(file_.get(), "{:.6f},0{}\n", time_s - release_s, rest);
  }
  before_.clear();
}

void MotionTrace::write(const Plant& plant) {
  fmt::memory_buffer rest;
  for (std::size_t i = 0; i < plant.joints(); ++i) {
    fmt::format_to(std::back_inserter(rest), ",{:.9g},{:.9g},{:.6g}", plant.position(i),
                   plant.velocity(i), plant.torque(i));
  }
  if (!plant.released()) {
    before_.emplace_back(plant.elapsed_s(), fmt::to_string(rest));
    if (before_.size() > kMostBefore) before_.pop_front();
    return;
  }
  const double release_s = *plant.report().release_s;
  flush_before(release_s);
  fmt::print(file_.get(), "{:.6f},1{}\n", plant.elapsed_s() - release_s, fmt::to_string(rest));
}

}  // namespace geodesic::tools
