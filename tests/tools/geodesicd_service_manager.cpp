// What a service manager hears.
#include "tools/geodesicd/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>

#include "drivers/bus/unix_address.hpp"
#include "tests/tools/geodesicd_fixture.hpp"

namespace geodesic::tools {
namespace {

using std::chrono::milliseconds;

TEST(ServiceManager, HearsReadyAliveAndStopping) {
  const TemporaryFolder folder;
  const auto address = drivers::UnixAddress::path((folder / "notify").string());
  const drivers::Descriptor listener(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0));
  ASSERT_EQ(::bind(listener.get(), address->get(), address->size()), 0);
  const auto heard = [&listener] {
    std::array<char, 256> text{};
    const ssize_t size = ::recv(listener.get(), text.data(), text.size(), 0);
    return std::string(text.data(), size < 0 ? 0 : static_cast<std::size_t>(size));
  };

  ServiceManager manager((folder / "notify").string(), "200000");
  manager.ready("connecting");
  EXPECT_EQ(heard(), "READY=1\nSTATUS=connecting");
  const ServiceManager::Clock::time_point start = ServiceManager::Clock::now();
  manager.alive(start);
  EXPECT_EQ(heard(), "WATCHDOG=1");
  manager.alive(start + milliseconds(99));
  EXPECT_EQ(heard(), "") << "half of the watchdog's time has not passed";
  manager.alive(start + milliseconds(100));
  EXPECT_EQ(heard(), "WATCHDOG=1");
  manager.stopping();
  EXPECT_EQ(heard(), "STOPPING=1");
}

TEST(ServiceManager, MayBeAbsent) {
  ServiceManager nobody("", "");
  nobody.ready("fine");
  nobody.alive(ServiceManager::Clock::now());
  ServiceManager gone("/nowhere/notify", "nonsense");
  gone.ready("fine");
  gone.alive(ServiceManager::Clock::now());
}

}  // namespace
}  // namespace geodesic::tools
