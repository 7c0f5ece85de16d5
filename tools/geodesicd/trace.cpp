// Telemetry as CSV.
#include "tools/geodesicd/trace.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <stdexcept>

namespace geodesic::tools {

Trace::Trace(const std::filesystem::path& file, const std::vector<std::string>& joints,
             std::size_t buses, std::int64_t every)
    : path_(file),
      joints_(joints.size()),
      buses_(buses),
      every_(every),
      file_(std::fopen(file.c_str(), "we")) {
  row_ = "time_s,state,law,authority,overran";
  for (const std::string& joint : joints) {
    fmt::format_to(std::back_inserter(row_),
                   ",q_{0},v_{0},torque_{0},command_{0},model_{0},external_{0}", joint);
  }
  for (std::size_t i = 0; i < buses; ++i) {
    fmt::format_to(std::back_inserter(row_), ",sent_{}", i);
  }
  row_ += '\n';
  if (file_ == nullptr || std::fputs(row_.c_str(), file_.get()) < 0 ||
      std::fflush(file_.get()) != 0) {
    throw std::runtime_error("cannot write the trace " + file.string() + ": " +
                             std::strerror(errno) + "; choose another by --trace FILE");
  }
}

std::optional<std::string> Trace::write(const Record& record) {
  if (file_ == nullptr || record.index < next_index_) {
    return std::nullopt;
  }
  if (first_tick_ns_ == 0) {
    first_tick_ns_ = record.tick_ns;
  }
  next_index_ = (record.index / every_ + 1) * every_;
  row_.clear();
  auto out = std::back_inserter(row_);
  fmt::format_to(out, "{:.6f},{},{},{:.4f},{}",
                 static_cast<double>(record.tick_ns - first_tick_ns_) * 1e-9,
                 control::to_string(record.state), control::to_string(record.law), record.authority,
                 record.overran ? 1 : 0);
  for (std::size_t i = 0; i < joints_; ++i) {
    const JointRecord& joint = record.joint[i];
    fmt::format_to(out, ",{:.7g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}", joint.position,
                   joint.velocity, joint.torque, joint.command, joint.model, joint.external);
  }
  for (std::size_t i = 0; i < buses_; ++i) {
    fmt::format_to(out, ",{}", record.sent[i]);
  }
  row_ += '\n';
  return std::fwrite(row_.data(), 1, row_.size(), file_.get()) == row_.size() ? std::nullopt
                                                                              : fail();
}

std::optional<std::string> Trace::flush() {
  return file_ == nullptr || std::fflush(file_.get()) == 0 ? std::nullopt : fail();
}

std::optional<std::string> Trace::fail() {
  std::string text = "the trace " + path_.string() + " ends here: " + std::strerror(errno);
  file_.reset();
  return text;
}

}  // namespace geodesic::tools
