// What must hold of everything the readers of robot files say.
#pragma once

#include <vector>

#include "config/robot.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {

/// @throws Violation unless every message can be shown, says where, and `ok` means no error.
inline void check_messages(const std::vector<config::Message>& messages, bool ok) {
  bool errors = false;
  for (const config::Message& message : messages) {
    errors = errors || message.severity == config::Message::Severity::kError;
    const std::string text = config::to_string(message);
    expect(is_printable(text), "a message can be shown on any terminal");
    expect(!message.place.file.empty(), "a message names its file");
    expect(message.place.line >= 1 && message.place.column >= 1, "a message has line and column");
    expect(message.text.size() >= 8, "a message says something");
  }
  expect(ok == !errors, "refused if and only if an error is told");
}

}  // namespace geodesic::fuzz
