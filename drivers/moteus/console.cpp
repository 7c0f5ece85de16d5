// One question to a moteus drive's console; see console.hpp.
#include "drivers/moteus/console.hpp"

#include <charconv>

namespace geodesic::drivers::moteus {

void Console::ask(std::string_view line) noexcept {
  line_ = line;
  step_ = Step::kEmpty;
  size_ = 0;
}

Frame Console::request(const Link& link) const noexcept {
  return step_ == Step::kSend ? encode_text(link, line_) : encode_poll(link);
}

bool Console::take(const Frame& reply) noexcept {
  Reader reader(reply);
  for (Entry entry; reader.next(entry);) {
    if (entry.kind != opcode::kServerToClient || entry.number != kDiagnosticChannel) {
      continue;
    }
    if (step_ == Step::kEmpty) {
      step_ = entry.text.empty() ? Step::kSend : Step::kEmpty;
      return true;
    }
    step_ = step_ == Step::kSend ? Step::kRead : step_;
    for (const char letter : entry.text) {
      if (letter == '\n') {
        step_ = Step::kAnswered;
        return true;
      }
      if (letter != '\r' && size_ < text_.size()) {
        text_[size_++] = letter;
      }
    }
    return true;
  }
  return false;
}

std::optional<double> Console::number() const noexcept {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text_.data(), text_.data() + size_, value);
  if (error != std::errc{} || end != text_.data() + size_) {
    return std::nullopt;
  }
  return value;
}

}  // namespace geodesic::drivers::moteus
