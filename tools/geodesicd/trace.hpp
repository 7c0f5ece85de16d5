// The trace: telemetry as CSV, at a rate people plot. Written by the service thread.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/geodesicd/telemetry.hpp"

namespace geodesic::tools {

/// Columns: time_s (since the first cycle), state, law, authority, overran, then for each joint
/// q_NAME, v_NAME, torque_NAME (as the drive reports), command_NAME, model_NAME, external_NAME
/// (observed); for each bus sent_N: frames handed to it in this cycle.
class Trace {
 public:
  /// @param every  one row for so many cycles, >= 1
  /// @throws std::runtime_error if the file cannot be written.
  Trace(const std::filesystem::path& file, const std::vector<std::string>& joints,
        std::size_t buses, std::int64_t every);

  /// A row, if it is time for one.
  /// @return what went wrong (a full disk); the trace ends there and says so once.
  std::optional<std::string> write(const Record& record);
  /// Hands what is buffered to the kernel. @return as write().
  std::optional<std::string> flush();

 private:
  struct Closer {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::optional<std::string> fail();

  std::filesystem::path path_;
  std::size_t joints_;
  std::size_t buses_;
  std::int64_t every_;
  std::int64_t next_index_ = 0;
  std::int64_t first_tick_ns_ = 0;
  std::string row_;
  std::unique_ptr<std::FILE, Closer> file_;
};

}  // namespace geodesic::tools
