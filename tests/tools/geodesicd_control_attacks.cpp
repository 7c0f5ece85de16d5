// What hostile, broken or forgotten clients of the control socket can do to the daemon: nothing.
// The server is stepped by hand here, so that what one round may cost can be counted.
#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "drivers/bus/descriptor.hpp"
#include "drivers/bus/unix_address.hpp"
#include "tests/tools/geodesicd_fixture.hpp"
#include "tools/geodesicd/control_peer.hpp"
#include "tools/geodesicd/control_socket.hpp"
#include "tools/geodesicd/requests.hpp"

namespace geodesic::tools {
namespace {

using drivers::Descriptor;
using std::chrono::milliseconds;

/// Of this thread: what others do meanwhile does not count.
double cpu_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

class ControlAttack : public testing::Test {  // NOLINT(cppcoreguidelines-virtual-class-destructor)
 protected:
  ControlAttack() {
    actions_.status = [] {
      return nlohmann::ordered_json{{"ok", true}, {"padding", std::string(16000, 'x')}};
    };
    actions_.hand_over = [](const control::Request&) { return true; };
    actions_.exit = [] {};
    actions_.ending = [] { return false; };
  }
  ~ControlAttack() override {
    std::cout << "  longest round: " << longest_ms_ << " ms of processor time, " << most_answers_
              << " answers\n";
  }

  /// One round of the service thread, without waiting for anybody.
  void round() {
    int answers = 0;
    const double begin = cpu_ms();
    server_.serve(milliseconds(0), [this, &answers](std::string_view line) {
      ++answers;
      return answer_request(line, actions_);
    });
    longest_ms_ = std::max(longest_ms_, cpu_ms() - begin);
    most_answers_ = std::max(most_answers_, answers);
    EXPECT_LE(server_.clients(), ControlServer::kMaxClients);
    EXPECT_LE(answers, static_cast<int>(ControlServer::kMaxClients * ControlServer::kMaxAnswers));
  }

  Descriptor client() const {
    Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto address = drivers::UnixAddress::path(server_.path().string());
    if (::connect(socket.get(), address->get(), address->size()) != 0) {
      socket.reset();
    }
    return socket;
  }
  static bool send(const Descriptor& to, std::string_view bytes) {
    return ::send(to.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) > 0;
  }
  /// Everything that has come; `ended`: and the other side has hung up.
  static std::string received(const Descriptor& from, bool* ended = nullptr) {
    std::string text;
    std::array<char, 65536> bytes;
    ssize_t got = 0;
    while ((got = ::recv(from.get(), bytes.data(), bytes.size(), MSG_DONTWAIT)) > 0) {
      text.append(bytes.data(), static_cast<std::size_t>(got));
    }
    if (ended != nullptr) {
      *ended = got == 0 || errno == ECONNRESET;
    }
    return text;
  }
  /// Rounds until an operator who comes now has an answer. @return rounds; 0: never.
  int rounds_to_answer() {
    Descriptor operator_socket;
    for (int rounds = 1; rounds <= 1000; ++rounds) {
      if (!operator_socket.valid()) {
        operator_socket = client();
        send(operator_socket, "{\"cmd\":\"stop\"}\n");
      }
      round();
      const std::string answer = received(operator_socket);
      if (answer.find("\"ok\":true") != std::string::npos) {
        return rounds;
      }
      if (!answer.empty()) {  // turned away for now
        operator_socket.reset();
        std::this_thread::sleep_for(milliseconds(1));
      }
    }
    return 0;
  }

  TemporaryFolder folder_;
  ControlPatience patience_{milliseconds(200), milliseconds(100), milliseconds(400),
                            milliseconds(20)};
  ControlServer server_{folder_ / "attacked.sock", patience_};
  RequestActions actions_;
  double longest_ms_ = 0.0;
  int most_answers_ = 0;
};

TEST_F(ControlAttack, HalfARequestDelaysNobodyAndIsDropped) {
  const Descriptor half = client();
  ASSERT_TRUE(send(half, "{\"cmd\":\"sta"));
  round();
  EXPECT_LE(rounds_to_answer(), 3);
  bool ended = false;
  for (int i = 0; i < 2000 && !ended; ++i) {
    round();
    received(half, &ended);
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_TRUE(ended) << "a request must end within ControlPatience::unfinished";
}

TEST_F(ControlAttack, ByteByByteIsNoWayToStay) {
  const Descriptor slow = client();
  bool ended = false;
  int bytes = 0;
  for (; bytes < 4000 && !ended; ++bytes) {
    send(slow, "x");
    round();
    received(slow, &ended);
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_TRUE(ended) << "it was heard of all the time, and yet never asked anything";
  EXPECT_LT(bytes, 4000);
}

TEST_F(ControlAttack, ByteByByteButInTimeIsAnswered) {
  patience_.unfinished = milliseconds(60000);
  ControlServer patient(folder_ / "patient.sock", patience_);
  Descriptor slow(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const auto address = drivers::UnixAddress::path(patient.path().string());
  ASSERT_EQ(::connect(slow.get(), address->get(), address->size()), 0);
  for (const char byte : std::string("{\"cmd\":\"stop\"}\n")) {
    ASSERT_TRUE(send(slow, {&byte, 1}));
    patient.serve(milliseconds(0),
                  [this](std::string_view line) { return answer_request(line, actions_); });
  }
  patient.serve(milliseconds(0),
                [this](std::string_view line) { return answer_request(line, actions_); });
  EXPECT_NE(received(slow).find("\"ok\":true"), std::string::npos);
}

TEST_F(ControlAttack, WhoNeverReadsCostsABoundedBufferAndIsDropped) {
  std::vector<Descriptor> stuck;
  for (std::size_t i = 0; i + 1 < ControlServer::kMaxClients; ++i) {
    stuck.push_back(client());
  }
  for (int i = 0; i < 300; ++i) {
    for (const Descriptor& each : stuck) {
      send(each, "{\"cmd\":\"status\"}\n{\"cmd\":\"status\"}\n{\"cmd\":\"status\"}\n");
    }
    round();
  }
  EXPECT_LE(rounds_to_answer(), 3) << "seven full buffers, and the eighth client is served";
  for (int i = 0; i < 2000 && server_.clients() > 0; ++i) {
    round();
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_EQ(server_.clients(), 0U) << "unread answers are kept for ControlPatience::unread";
}

TEST_F(ControlAttack, AFloodOfRequestsIsAnsweredAFewARound) {
  std::vector<Descriptor> flood;
  for (std::size_t i = 0; i < ControlServer::kMaxClients; ++i) {
    flood.push_back(client());
  }
  round();
  for (int i = 0; i < 200; ++i) {
    for (const Descriptor& each : flood) {
      send(each, std::string(ControlServer::kMaxRequest, '\n'));
      received(each);
    }
    round();
  }
  EXPECT_EQ(most_answers_,
            static_cast<int>(ControlServer::kMaxClients * ControlServer::kMaxAnswers));
}

TEST_F(ControlAttack, NothingAskedIsLostInAFlood) {
  const Descriptor busy = client();
  constexpr int kRequests = 200;
  std::string requests;
  for (int i = 0; i < kRequests; ++i) {
    requests += "{\"cmd\":\"stop\"}\n";
  }
  ASSERT_TRUE(send(busy, requests));
  ::shutdown(busy.get(), SHUT_WR);
  std::string answers;
  bool ended = false;
  for (int i = 0; i < 100 && !ended; ++i) {
    round();
    answers += received(busy, &ended);
  }
  EXPECT_TRUE(ended);
  EXPECT_EQ(std::count(answers.begin(), answers.end(), '\n'), kRequests);
}

TEST_F(ControlAttack, AThousandConnectionsComeAndGo) {
  for (int i = 0; i < 1000; ++i) {
    const Descriptor brief = client();
    if (i % 3 == 0) {
      send(brief, "{\"cmd\"");
    }
    if (i % 4 == 0) {
      round();
    }
  }
  EXPECT_GT(rounds_to_answer(), 0);
}

TEST_F(ControlAttack, AFloodOfConnectionsThatStayLetsTheOperatorIn) {
  std::vector<Descriptor> flood;
  for (int i = 0; i < 200; ++i) {
    flood.push_back(client());
    round();
  }
  EXPECT_GT(rounds_to_answer(), 0) << "the longest silent one gives way";
}

TEST_F(ControlAttack, WithoutDescriptorsTheThreadRestsAndRecovers) {
  std::vector<Descriptor> waiting;
  waiting.push_back(client());
  waiting.push_back(client());
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  // Every number below the limit is taken: accept() has none left.
  std::vector<Descriptor> fill;
  fill.emplace_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  const rlimit few{static_cast<rlim_t>(fill.back().get()) + 1, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  round();
  EXPECT_EQ(server_.clients(), 0U);
  const auto begin = std::chrono::steady_clock::now();
  server_.serve(milliseconds(20), [](std::string_view) { return std::string("{}"); });
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(19)) << "it must not spin";
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  fill.clear();
  std::this_thread::sleep_for(milliseconds(220));
  EXPECT_GT(rounds_to_answer(), 0);
}

TEST_F(ControlAttack, StrangersAreTurnedAwayEvenWhereTheModeLetsThemIn) {
  // Only root can become somebody else; anybody else is told apart by the rule alone, below.
  ASSERT_EQ(::chmod(server_.path().c_str(), 0666), 0);
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0755), 0);
  constexpr uid_t kNobody = 65534;
  const bool root = ::geteuid() == 0;
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (root &&
        (::setgroups(0, nullptr) != 0 || ::setgid(kNobody) != 0 || ::setuid(kNobody) != 0)) {
      ::_exit(1);
    }
    const Descriptor stranger = client();
    send(stranger, "{\"cmd\":\"stop\"}\n");
    (void)!::write(pipe[1], "x", 1);
    std::string answer;
    for (int i = 0; i < 5000 && answer.empty(); ++i) {
      answer = received(stranger);
      ::usleep(1000);
    }
    const bool refused = answer.find("only the daemon's user") != std::string::npos;
    const bool answered = answer.find("\"ok\":true") != std::string::npos;
    ::_exit((root ? refused : answered) ? 0 : 2);
  }
  char ready = 0;
  ASSERT_EQ(::read(pipe[0], &ready, 1), 1);
  int status = -1;
  for (int i = 0; i < 6000 && ::waitpid(child, &status, WNOHANG) == 0; ++i) {
    round();
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_EQ(status, 0);
  ::close(pipe[0]);
  ::close(pipe[1]);
}

TEST(ControlPeer, OwnerRootAndGroupMayAsk) {
  EXPECT_TRUE(may_ask({1000, {5, 6}}, 1000, 7));
  EXPECT_TRUE(may_ask({0, {}}, 1000, 7));
  EXPECT_TRUE(may_ask({1001, {5, 7}}, 1000, 7));
  EXPECT_FALSE(may_ask({1001, {5, 6}}, 1000, 7));
  EXPECT_FALSE(may_ask({1001, {}}, 1000, 7));
}

TEST(ControlPeer, IsWhoTheKernelSays) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
  const auto peer = control_peer(ends[0]);
  ASSERT_TRUE(peer);
  EXPECT_EQ(peer->uid, ::geteuid());
  EXPECT_NE(std::find(peer->groups.begin(), peer->groups.end(), ::getegid()), peer->groups.end());
  ::close(ends[0]);
  ::close(ends[1]);
  EXPECT_FALSE(control_peer(-1));
}

TEST(ControlServerMode, IsRightWhateverTheUmaskAndNeverWider) {
  const TemporaryFolder folder;
  for (const mode_t mask : {0000U, 0002U, 0022U, 0027U, 0077U, 0777U}) {
    const mode_t before = ::umask(mask);
    const ControlServer server(folder / "mode.sock");
    ::umask(before);
    struct stat status {};
    ASSERT_EQ(::stat((folder / "mode.sock").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0660U) << "umask " << mask;
  }
}

TEST(ControlServerMode, AFolderThatAnybodyMayWriteIsRefused) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "open");
  ASSERT_EQ(::chmod((folder / "open").c_str(), 0777), 0);
  EXPECT_THROW(ControlServer(folder / "open/a.sock"), ControlError);
  ASSERT_EQ(::chmod((folder / "open").c_str(), 01777), 0);
  EXPECT_NO_THROW(ControlServer(folder / "open/a.sock")) << "as /tmp";
}

}  // namespace
}  // namespace geodesic::tools
