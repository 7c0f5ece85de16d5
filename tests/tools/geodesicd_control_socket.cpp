// The control socket: who may reach it, what bad clients can do to it (nothing), who else serves
// it.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>

#include "drivers/bus/descriptor.hpp"
#include "drivers/bus/unix_address.hpp"
#include "tests/tools/geodesicd_fixture.hpp"
#include "tools/geodesicd/control_socket.hpp"
#include "tools/geodesicd/requests.hpp"

namespace geodesic::tools {
namespace {

using std::chrono::milliseconds;

/// A served socket; the answer to `status` is as long as that of a big robot.
class ControlSocketTest : public testing::Test {
 public:
  ~ControlSocketTest() override { end(); }

 protected:
  ControlSocketTest() : server_(folder_ / "bench.sock") {
    actions_.status = [] {
      return nlohmann::ordered_json{{"ok", true}, {"padding", std::string(16000, 'x')}};
    };
    actions_.hand_over = [this](const control::Request& request) {
      handed_over_ = request;
      return true;
    };
    actions_.exit = [this] { exit_asked_ = true; };
    actions_.ending = [] { return false; };
    thread_ = std::thread([this] {
      while (!done_) {
        server_.serve(milliseconds(5),
                      [this](std::string_view line) { return answer_request(line, actions_); });
        clients_ = server_.clients();
      }
    });
  }
  void end() {
    done_ = true;
    if (thread_.joinable()) {
      thread_.join();
    }
  }

  drivers::Descriptor raw_client() {
    drivers::Descriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const auto address = drivers::UnixAddress::path(server_.path().string());
    EXPECT_EQ(::connect(client.get(), address->get(), address->size()), 0);
    return client;
  }

  static std::string exchange(int client, const std::string& bytes, bool half_close = false) {
    EXPECT_EQ(::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
    if (half_close) {
      ::shutdown(client, SHUT_WR);
    }
    std::string answer;
    char byte = 0;
    while (::recv(client, &byte, 1, 0) == 1 && byte != '\n') {
      answer += byte;
    }
    return answer;
  }

  bool wait_for_clients(std::size_t count) {
    for (int i = 0; i < 1000 && clients_ != count; ++i) {
      std::this_thread::sleep_for(milliseconds(5));
    }
    return clients_ == count;
  }

  TemporaryFolder folder_;
  ControlServer server_;
  RequestActions actions_;
  control::Request handed_over_;
  std::atomic<bool> exit_asked_{false};
  std::atomic<bool> done_{false};
  std::atomic<std::size_t> clients_{0};
  std::thread thread_;
};

TEST_F(ControlSocketTest, AnswersRequests) {
  ControlClient client(server_.path());
  EXPECT_TRUE(client.request({{"cmd", "status"}}).at("ok").get<bool>());
  EXPECT_TRUE(client.request({{"cmd", "law"}, {"law", "hold"}}).at("ok").get<bool>());
  EXPECT_TRUE(client.request({{"cmd", "stop"}, {"exit", true}}).at("exit").get<bool>());
  end();
  EXPECT_EQ(handed_over_.kind, control::Request::Kind::kLaw);
  EXPECT_EQ(handed_over_.law, control::LawKind::kHold);
  EXPECT_TRUE(exit_asked_);
}

TEST_F(ControlSocketTest, TellsWhatIsWrongWithARequest) {
  ControlClient client(server_.path());
  const auto error = [&client](const nlohmann::json& request) {
    const nlohmann::json answer = client.request(request);
    EXPECT_FALSE(answer.at("ok").get<bool>());
    return answer.at("error").get<std::string>();
  };
  EXPECT_NE(error({{"cmd", "law"}, {"law", "flaot"}}).find("did you mean \"float\""),
            std::string::npos);
  EXPECT_NE(error({{"cmd", "law"}, {"law", "zero"}}).find("--allow-zero-law"), std::string::npos);
  EXPECT_NE(error({{"cmd", "law"}}).find("name of a law"), std::string::npos);
  EXPECT_NE(error({{"cmd", "stats"}}).find("did you mean \"status\""), std::string::npos);
  EXPECT_NE(error({{"cmd", "stop"}, {"exit", "yes"}}).find("true or false"), std::string::npos);
  EXPECT_NE(error({{"command", "stop"}}).find("\"cmd\" is missing"), std::string::npos);
}

TEST_F(ControlSocketTest, SurvivesGarbage) {
  const drivers::Descriptor client = raw_client();
  for (const std::string& garbage :
       {std::string("\n"), std::string("{\n"), std::string("[[[[[[[\n"), std::string("null\n"),
        std::string("\xff\xfe\x00\n", 4), std::string(4000, '[') + "\n",
        std::string("{\"cmd\":{\"cmd\":1}}\n")}) {
    const auto answer = nlohmann::json::parse(exchange(client.get(), garbage));
    EXPECT_FALSE(answer.at("ok").get<bool>());
    EXPECT_FALSE(answer.at("error").get<std::string>().empty());
  }
}

TEST_F(ControlSocketTest, RefusesALineThatIsTooLong) {
  const drivers::Descriptor client = raw_client();
  const std::string answer = exchange(client.get(), std::string(ControlServer::kMaxRequest, 'x'));
  EXPECT_NE(answer.find("longer than 4096"), std::string::npos);
  char byte = 0;
  EXPECT_EQ(::recv(client.get(), &byte, 1, 0), 0) << "the client is dropped";
}

TEST_F(ControlSocketTest, AnswersAClientThatHasClosedItsSide) {
  const drivers::Descriptor client = raw_client();
  const std::string answer = exchange(client.get(), "{\"cmd\":\"status\"}\n", true);
  EXPECT_TRUE(nlohmann::json::parse(answer).at("ok").get<bool>());
}

TEST_F(ControlSocketTest, DropsAClientThatDoesNotReadAndDelaysNobody) {
  const drivers::Descriptor stuck = raw_client();
  std::string flood;
  for (int i = 0; i < 200; ++i) {
    flood += "{\"cmd\":\"status\"}\n";
  }
  while (::send(stuck.get(), flood.data(), flood.size(), MSG_NOSIGNAL | MSG_DONTWAIT) > 0) {
  }
  ControlClient good(server_.path());
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(good.request({{"cmd", "status"}}).at("ok").get<bool>());
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, milliseconds(1500));
  EXPECT_TRUE(wait_for_clients(1)) << "the stuck client is gone after ControlPatience::unread";
}

TEST_F(ControlSocketTest, ServesAtMostEightClients) {
  std::vector<drivers::Descriptor> clients;
  for (std::size_t i = 0; i < ControlServer::kMaxClients; ++i) {
    clients.push_back(raw_client());
  }
  ASSERT_TRUE(wait_for_clients(ControlServer::kMaxClients));
  const drivers::Descriptor ninth = raw_client();
  std::array<char, 256> answer{};
  ASSERT_GT(::recv(ninth.get(), answer.data(), answer.size() - 1, 0), 0);
  EXPECT_NE(std::strstr(answer.data(), "as many clients"), nullptr);
  clients.pop_back();
  ASSERT_TRUE(wait_for_clients(ControlServer::kMaxClients - 1));
  EXPECT_FALSE(exchange(raw_client().get(), "{}\n").empty());
}

TEST_F(ControlSocketTest, IsOpenToOwnerAndGroupOnly) {
  const ControlServer nested(folder_ / "new/bench.sock");
  struct stat status {};
  ASSERT_EQ(::stat((folder_ / "new/bench.sock").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0660U);
  ASSERT_EQ(::stat((folder_ / "new").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0027U, 0U);
}

TEST_F(ControlSocketTest, ASecondServerIsRefusedWithThePid) {
  try {
    const ControlServer second(server_.path());
    FAIL() << "two servers on one path";
  } catch (const ControlError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("already running (pid " + std::to_string(::getpid()) + ")"),
              std::string::npos)
        << text;
  }
  EXPECT_TRUE(ControlClient(server_.path()).request({{"cmd", "status"}}).at("ok").get<bool>());
}

TEST(ControlServer, ReplacesAStaleSocketButNothingElse) {
  const TemporaryFolder folder;
  const auto address = drivers::UnixAddress::path((folder / "a.sock").string());
  {
    const drivers::Descriptor dead(::socket(AF_UNIX, SOCK_STREAM, 0));
    ASSERT_EQ(::bind(dead.get(), address->get(), address->size()), 0);
  }
  ASSERT_TRUE(std::filesystem::exists(folder / "a.sock"));
  { const ControlServer server(folder / "a.sock"); }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.sock")) << "it goes with its server";

  std::ofstream(folder / "precious") << "text";
  EXPECT_THROW(ControlServer(folder / "precious"), ControlError);
  EXPECT_EQ(read_text(folder / "precious"), "text");
  EXPECT_THROW(ControlServer(folder / std::string(200, 'x')), ControlError);
}

TEST(ControlClient, TellsThatNobodyServes) {
  const TemporaryFolder folder;
  try {
    ControlClient client(folder / "nobody.sock");
    FAIL() << "connected to nobody";
  } catch (const ControlError& error) {
    EXPECT_NE(std::string(error.what()).find("no daemon serves"), std::string::npos);
  }
}

TEST(ControlPath, IsTheFirstThatCanBeWritten) {
  const TemporaryFolder folder;
  PathEnvironment environment;
  environment.uid = 1234;
  environment.run_dir = folder / "absent";
  environment.tmp_dir = folder.path();
  EXPECT_EQ(control_path("arm", environment), folder / "geodesic-1234/arm.sock");

  std::filesystem::create_directory(folder / "run");
  environment.run_dir = folder / "run";
  EXPECT_EQ(control_path("arm", environment), folder / "run/geodesic/arm.sock");

  std::filesystem::create_directory(folder / "user");
  environment.runtime_dir = folder / "user";
  EXPECT_EQ(control_path("arm", environment), folder / "user/geodesic/arm.sock");
  EXPECT_EQ(control_path_candidates("arm", environment).size(), 3U);
}

TEST(ControlPath, KeepsStrangeNamesInsideTheFolder) {
  PathEnvironment environment;
  environment.runtime_dir = "/run/user/1";
  EXPECT_EQ(control_path_candidates("../../etc/arm 1", environment).front(),
            "/run/user/1/geodesic/_._.._etc_arm_1.sock");
  EXPECT_EQ(control_path_candidates("", environment).front(), "/run/user/1/geodesic/robot.sock");
}

}  // namespace
}  // namespace geodesic::tools
