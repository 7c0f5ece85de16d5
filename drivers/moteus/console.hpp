// One question to a drive's console and its answer, through the tunnelled diagnostic stream: what
// no register tells (gains, gear) and what is kept over power-off. Texts are moteus'.
// Real-time throughout.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/moteus/codec.hpp"

namespace geodesic::drivers::moteus {

class Console {
 public:
  /// What was left unread of earlier answers is read away first; then `line` (a literal that ends
  /// in a line feed) is sent, and the answer asked for until it ends a line.
  void ask(std::string_view line) noexcept;
  /// The frame that is due; each is answered by one.
  Frame request(const Link& link) const noexcept;
  /// Takes the drive's piece of the stream. @return the request was answered.
  bool take(const Frame& reply) noexcept;
  bool answered() const noexcept { return step_ == Step::kAnswered; }
  /// The answer's first line, without its end.
  std::string_view answer() const noexcept { return {text_.data(), size_}; }
  /// That line as a number; nothing if it is none.
  std::optional<double> number() const noexcept;

 private:
  enum class Step : std::uint8_t { kEmpty, kSend, kRead, kAnswered };

  std::string_view line_;
  Step step_ = Step::kAnswered;
  std::array<char, 64> text_{};
  std::size_t size_ = 0;
};

}  // namespace geodesic::drivers::moteus
