// A real controller's driver (kvaser_pci, sja1000) brought up by netlink, held, unplugged and put
// back: can0 and can1 on one wire, as tests/lab/rt-machine has them. Errors on the wire are not
// emulated there.
#include <net/if.h>

#include <cstdlib>
#include <filesystem>

#include "drivers/bus/can_link.hpp"
#include "drivers/bus/interface_name.hpp"
#include "tests/drivers/bus/held_bus.hpp"

namespace geodesic::drivers {
namespace {

using testing::error_text;
using testing::eventually;
using testing::hold_for_a_second;
using testing::ids;
using testing::kMillisecond;
using testing::make_cycle;
using testing::receive;
using testing::send_when_free;
using testing::Tender;

void run(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

std::string text_of(const std::vector<BusNews>& news) {
  std::string text;
  for (const BusNews& one : news) text += (one.warning ? "! " : "") + one.text + "\n";
  return text;
}

class KvaserLink : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(::if_nametoindex("can0"), 0U) << "run this by tests/lab/rt-machine";
    run("ip link set can0 down; ip link set can1 down");
    run("ip link set can1 up txqueuelen 64 type can bitrate 500000");
  }
  void TearDown() override { run("tc qdisc del dev can0 root 2>/dev/null || true"); }

  static BusOptions commander() {
    BusOptions options;
    options.name = "arm";
    options.interface = "can0";
    options.bring_up = true;
    options.bit_rate = 500'000;
    options.receive = ids(0x11, 8);
    options.transmit = ids(0x01, 8);
    return options;
  }
  static std::unique_ptr<Bus> drive() {
    BusOptions options;
    options.interface = "can1";
    return open_bus(options);
  }
  CanLink link() {
    int error = 0;
    return port_.read("can0", error).value_or(CanLink());
  }

  KernelLinkPort port_;
};

TEST_F(KvaserLink, IsBroughtUpAsConfigured) {
  BusOptions options = commander();
  options.sample_point = 0.8;
  options.restart_ms = 50;
  options.queue = 32;
  const auto host = open_bus(options);
  const CanLink found = link();
  EXPECT_TRUE(found.up && found.echoes && found.has_controller());
  EXPECT_EQ(found.nominal.bit_rate, 500'000);
  EXPECT_EQ(found.nominal.quanta, 16);  // of a clock of 8 MHz: 13 of them would be 0.8125
  EXPECT_NEAR(found.nominal.sample_point.value_or(0.0), 0.8, 1.0 / 16);
  EXPECT_EQ(found.restart_ms, 50);
  EXPECT_EQ(found.queue, 32);
  const auto other = drive();
  ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 2, 1)));
  EXPECT_EQ(receive(*other, 2).size(), 2U);
  host->tend();
  EXPECT_EQ(host->health().state, ControllerState::kActive);
  EXPECT_EQ(host->health().device, "can0");
}

TEST_F(KvaserLink, IsSetUpAnewWhereItIsUpOtherwise) {
  run("ip link set can0 up txqueuelen 10 type can bitrate 1000000 restart-ms 0");
  BusOptions options = commander();
  options.restart_ms = 100;
  BusOptions checked = options;
  checked.bring_up = false;
  EXPECT_EQ(
      error_text([&] { open_bus(checked); }),
      "arm: interface can0 is otherwise than configured: bit rate 1000000, configured 500000; "
      "restart-ms 0, configured 100; fix: ip link set can0 down && ip link set can0 txqueuelen "
      "64 up type can bitrate 500000 restart-ms 100");
  const auto host = open_bus(options);
  EXPECT_EQ(link().nominal.bit_rate, 500'000);
  EXPECT_EQ(link().restart_ms, 100);
}

TEST_F(KvaserLink, ItsLineHelps) {
  run("ip link set can0 up type can bitrate 1000000");
  BusOptions checked = commander();
  checked.bring_up = false;
  const std::string text = error_text([&] { open_bus(checked); });
  const std::size_t fix = text.find("fix: ");
  ASSERT_NE(fix, std::string::npos) << text;
  run(text.substr(fix + 5));
  open_bus(checked);
}

TEST_F(KvaserLink, WhatItCannotIsRefusedInTheKernelsWords) {
  BusOptions options = commander();
  options.fd = true;  // an SJA1000 knows no CAN FD
  const std::string text = error_text([&] { open_bus(options); });
  EXPECT_NE(text.find("setting it up was refused by the kernel"), std::string::npos) << text;
  EXPECT_NE(text.find("not supported"), std::string::npos) << text;
  EXPECT_FALSE(link().up);
}

TEST_F(KvaserLink, HeldForASecondItDeliversNoOldCommand) {
  const auto host = open_bus(commander());
  const auto other = drive();
  Tender tender(*host);
  const auto result = hold_for_a_second(*host, *other, [](bool held) {
    run(std::string("tc qdisc ") + (held ? "add" : "change") + " dev can0 root tbf rate " +
        (held ? "128bit burst 32" : "10mbit burst 3200") + " limit 10000");
  });
  tender.stop();
  EXPECT_GE(result.arrived_before, 50U);
  EXPECT_GE(result.arrived_after, 50U);
  // The bus is taken down 15 ms after it was handed the frames, the thread that does it wakes every
  // 5 ms, and the frames take 2 ms.
  EXPECT_LT(result.oldest_ns, 30 * kMillisecond + result.longest_pause_ns);
  EXPECT_GT(host->health().purged, 0U);
  EXPECT_EQ(host->health().reopened, 0U);
  EXPECT_FALSE(host->state().down);
}

TEST_F(KvaserLink, UnpluggedAndBackItIsSetUpAndOpenedAnew) {
  const auto host = open_bus(commander());
  const auto other = drive();
  const unsigned index = ::if_nametoindex("can0");
  const std::string device =
      std::filesystem::canonical("/sys/class/net/can0/device").filename().string();
  const std::string driver = "/sys/bus/pci/drivers/kvaser_pci/";
  Tender tender(*host);
  ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 2, 1)));
  run("echo " + device + " > " + driver + "unbind");
  EXPECT_TRUE(eventually([&] {
    host->send(make_cycle(0x01, 2, 2));
    std::array<ReceivedFrame, 16> ignored;
    host->receive(ignored);
    return host->state().down;
  }));
  run("echo " + device + " > " + driver + "bind");
  EXPECT_TRUE(send_when_free(*host, make_cycle(0x01, 2, 3)));
  EXPECT_FALSE(host->state().down);
  tender.stop();
  EXPECT_NE(::if_nametoindex("can0"), index) << "a new interface";
  EXPECT_EQ(link().nominal.bit_rate, 500'000) << "set up anew";
  EXPECT_EQ(host->health().reopened, 1U);
  bool arrived = false;
  for (const ReceivedFrame& frame : receive(*other, 4, 500 * kMillisecond)) {
    arrived = arrived || frame.frame.data[0] == 3;
  }
  EXPECT_TRUE(arrived);
  const std::string news = text_of(host->take_news());
  EXPECT_NE(news.find("! arm: interface can0 has gone"), std::string::npos) << news;
  EXPECT_NE(news.find("is back and open again"), std::string::npos) << news;
}

TEST_F(KvaserLink, ACardOnNoUsbHasNoPlaceButItsName) {
  for (const AdapterPlace& place : can_adapters()) {
    EXPECT_TRUE(place.usb.empty() && place.serial.empty()) << place.device;
  }
  EXPECT_NE(error_text([] { resolve_interface("usb:1-1"); }).find("can0; can1"), std::string::npos);
}

}  // namespace
}  // namespace geodesic::drivers
