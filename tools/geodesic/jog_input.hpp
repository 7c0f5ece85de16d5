// What the person at the joint asks for: keys of a terminal, or lines on standard input. Says what
// was asked and when it arrived; how long that counts is jog_law's.
#pragma once

#include <termios.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "tools/geodesic/jog_law.hpp"

namespace geodesic::tools {

class JogInput {
 public:
  /// Reads from `file` without ever waiting; a terminal is set to give single keys, and set back at
  /// the end. @param torque  what a key or a bare sign asks for, the bound [N·m or N]
  JogInput(int file, double torque);
  ~JogInput();
  JogInput(const JogInput&) = delete;
  JogInput& operator=(const JogInput&) = delete;

  /// Takes in all that has arrived; the last of it counts.
  void poll(std::int64_t now_ns);

  const JogRequest& request() const { return request_; }
  bool ended() const { return ended_; }  ///< asked to end, or nobody can ask any more
  bool terminal() const { return terminal_; }
  /// What could not be understood; empty: nothing. It counts as letting go. Cleared by asking.
  std::string take_complaint();

 private:
  void take_keys(std::string_view keys, std::int64_t now_ns);
  void take_line(std::string_view line, std::int64_t now_ns);

  int file_;
  double torque_;
  bool terminal_ = false;
  bool ended_ = false;
  int flags_ = 0;
  termios before_{};
  std::string line_;
  std::string complaint_;
  JogRequest request_;
};

}  // namespace geodesic::tools
