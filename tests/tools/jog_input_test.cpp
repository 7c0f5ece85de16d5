// Keys of a terminal and lines of a pipe as requests for torque, and what is no request.
#include "tools/geodesic/jog_input.hpp"

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <string>

namespace geodesic::tools::test {
namespace {

/// A terminal, or a pipe, and the reader at its end.
struct Person {
  explicit Person(bool at_terminal) {
    if (at_terminal) {
      EXPECT_EQ(::openpty(&hand, &ear, nullptr, nullptr, nullptr), 0);
      ::tcgetattr(ear, &before);
    } else {
      std::array<int, 2> pipe{};
      EXPECT_EQ(::pipe(pipe.data()), 0);
      ear = pipe[0];
      hand = pipe[1];
    }
  }
  ~Person() {
    if (hand >= 0) ::close(hand);
    ::close(ear);
  }
  Person(const Person&) = delete;
  Person& operator=(const Person&) = delete;

  double asks(JogInput& input, const std::string& text) {
    EXPECT_EQ(::write(hand, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    input.poll(++now_ns);
    return input.request().torque;
  }

  int hand = -1;
  int ear = -1;
  termios before{};
  std::int64_t now_ns = 100;
};

TEST(JogInput, TakesKeysOfATerminal) {
  Person person(true);
  {
    JogInput input(person.ear, 0.4);
    EXPECT_TRUE(input.terminal());
    input.poll(1);
    EXPECT_EQ(input.request().torque, 0.0);
    for (const char* key : {"+", "=", "d", "\033[C", "\033[A"}) {
      EXPECT_EQ(person.asks(input, key), 0.4);
      EXPECT_EQ(input.request().stamp_ns, person.now_ns);
    }
    for (const char* key : {"-", "a", "\033[D", "\033[B"}) EXPECT_EQ(person.asks(input, key), -0.4);
    input.poll(5000);  // nothing more: the last one ages
    EXPECT_EQ(input.request().stamp_ns, person.now_ns);
    EXPECT_EQ(person.asks(input, " "), 0.0);
    EXPECT_EQ(person.asks(input, "-+x"), 0.0);
    EXPECT_FALSE(input.ended());
    person.asks(input, "q");
    EXPECT_TRUE(input.ended());
  }
  termios after{};
  ::tcgetattr(person.ear, &after);
  EXPECT_EQ(after.c_lflag, person.before.c_lflag);
}

TEST(JogInput, EndsWithItsTerminal) {
  Person person(true);
  JogInput input(person.ear, 0.4);
  EXPECT_EQ(person.asks(input, "+"), 0.4);
  ::close(person.hand);
  person.hand = -1;
  input.poll(200);
  EXPECT_TRUE(input.ended());
  EXPECT_EQ(input.request().torque, 0.0);
}

TEST(JogInput, TakesLinesOfAPipe) {
  Person person(false);
  JogInput input(person.ear, 0.4);
  EXPECT_FALSE(input.terminal());
  EXPECT_EQ(person.asks(input, "+\n"), 0.4);
  EXPECT_EQ(person.asks(input, "-\r\n"), -0.4);
  EXPECT_EQ(person.asks(input, " 0.25 \n"), 0.25);
  EXPECT_EQ(person.asks(input, "+0.1\n-0.2\n"), -0.2);
  EXPECT_EQ(person.asks(input, "0.3"), -0.2);  // no whole line yet
  EXPECT_EQ(person.asks(input, "\n"), 0.3);
  EXPECT_EQ(input.take_complaint(), "");
  for (const char* wrong : {"0.5\n", "nan\n", "inf\n", "--\n", "0.1x\n", "+-0.1 2\n"}) {
    person.asks(input, "+\n");
    EXPECT_EQ(person.asks(input, wrong), 0.0) << wrong;
    EXPECT_NE(input.take_complaint(), "") << wrong;
  }
  std::string endless(5000, '7');
  endless += '\n';
  EXPECT_EQ(person.asks(input, endless), 0.0);
  EXPECT_EQ(person.asks(input, "+\n\n"), 0.0);
  EXPECT_FALSE(input.ended());
  ::close(person.hand);
  person.hand = -1;
  input.poll(300);
  EXPECT_TRUE(input.ended());
}

}  // namespace
}  // namespace geodesic::tools::test
