// The true motion of the simulated arm as a CSV file. SI units; the first line names the columns.
#pragma once

#include <cstdio>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "tools/sim/plant.hpp"

namespace geodesic::tools {

/// Columns: time_s, released (0 or 1), then of every joint q_NAME, v_NAME, torque_NAME (the
/// drive's, at the joint). time_s counts from the release, negative before it; an arm that is never
/// released has times from the start. What precedes the release is kept in memory until then, the
/// last kMostBefore lines of it.
class MotionTrace {
 public:
  static constexpr std::size_t kMostBefore = 100'000;

  /// Opens the file and writes the column names. @throws std::runtime_error if it cannot.
  MotionTrace(const std::filesystem::path& file, const Plant& plant);
  ~MotionTrace();
  MotionTrace(const MotionTrace&) = delete;
  MotionTrace& operator=(const MotionTrace&) = delete;

  /// One line: the present state.
  void write(const Plant& plant);

 private:
  void flush_before(double release_s);

  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::deque<std::pair<double, std::string>> before_;  // time since start, rest of the line
};

}  // namespace geodesic::tools
