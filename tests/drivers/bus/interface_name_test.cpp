// Interfaces by name, USB path and serial number, in a /sys of the test's own.
#include "drivers/bus/interface_name.hpp"

#include <filesystem>
#include <fstream>

#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

namespace fs = std::filesystem;
using testing::error_text;

// NOLINTNEXTLINE(cppcoreguidelines-virtual-class-destructor)
class InterfaceName : public ::testing::Test {
 protected:
  InterfaceName() {
    std::string name = (fs::temp_directory_path() / "geodesic-sys-XXXXXX").string();
    sys_ = ::mkdtemp(name.data());
    fs::create_directories(sys_ / "class/net");
  }
  ~InterfaceName() override { fs::remove_all(sys_); }

  static void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text << '\n';
  }
  /// A network interface of the device in `folder`, as the kernel lays it out.
  void interface(const std::string& name, const fs::path& folder, int index, int dev_id = 0,
                 int type = 280) {
    const fs::path net = folder / "net" / name;
    write(net / "type", std::to_string(type));
    write(net / "ifindex", std::to_string(index));
    write(net / "dev_port", "0");
    write(net / "dev_id", "0x" + std::to_string(dev_id));
    fs::create_directory_symlink("../..", net / "device");
    fs::create_directory_symlink(net, sys_ / "class/net" / name);
  }
  fs::path usb(const std::string& path, const std::string& serial) {
    const fs::path device = sys_ / "devices/pci0000:00/0000:00:14.0/usb1" / path;
    write(device / "idVendor", "1d50");
    if (!serial.empty()) write(device / "serial", serial);
    return device / (path + ":1.0");
  }

  fs::path sys_;
};

TEST_F(InterfaceName, APlainNameIsItself) {
  EXPECT_EQ(resolve_interface("can0", sys_), "can0");
  EXPECT_EQ(resolve_interface("vcan7", sys_), "vcan7");
}

TEST_F(InterfaceName, AnAdapterIsFoundByItsSocketAndByItsNumber) {
  interface("can1", usb("1-2.3", "0032004A"), 5);
  interface("can0", usb("1-2.4", "0077001B"), 6);
  interface("eth0", usb("1-3", "0032004A"), 2, 0, 1);  // no CAN
  EXPECT_EQ(resolve_interface("usb:1-2.3", sys_), "can1");
  EXPECT_EQ(resolve_interface("usb:1-2.4", sys_), "can0");
  EXPECT_EQ(resolve_interface("serial:0032004A", sys_), "can1");
  EXPECT_EQ(resolve_interface("serial:0032004A/0", sys_), "can1");
  const auto all = can_adapters(sys_);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].usb, "1-2.3");
  EXPECT_EQ(all[0].serial, "0032004A");
}

TEST_F(InterfaceName, ChannelsOfOneAdapterAreCounted) {
  const fs::path device = usb("3-1", "ABC");
  interface("can5", device, 9, 0);
  interface("can4", device, 8, 1);  // named the other way round
  EXPECT_EQ(resolve_interface("usb:3-1/0", sys_), "can5");
  EXPECT_EQ(resolve_interface("serial:ABC/1", sys_), "can4");
  const std::string text = error_text([&] { resolve_interface("serial:ABC", sys_); });
  EXPECT_NE(text.find("serial:ABC has 2 CAN channels: can5 is usb:3-1/0, serial:ABC/0; can4 is "
                      "usb:3-1/1, serial:ABC/1; fix: say which, as in serial:ABC/0"),
            std::string::npos)
      << text;
}

TEST_F(InterfaceName, WhatIsNotThereIsSaidWithWhatIs) {
  interface("can0", sys_ / "devices/pci0000:00/0000:00:05.0", 3);
  const std::string text = error_text([&] { resolve_interface("usb:1-9", sys_); });
  EXPECT_NE(text.find("no CAN interface at usb:1-9; those that are there: can0; fix: plug"),
            std::string::npos)
      << text;
  EXPECT_NE(error_text([&] {
              resolve_interface("serial:X", sys_ / "none");
            }).find("there is no CAN interface at all"),
            std::string::npos);
}

TEST_F(InterfaceName, TwoAdaptersOfOneNumberAreNotGuessed) {
  interface("can0", usb("1-1", "000000"), 3);
  interface("can1", usb("1-2", "000000"), 4);
  EXPECT_NE(error_text([&] { resolve_interface("serial:000000", sys_); }).find("2 CAN channels"),
            std::string::npos);
  EXPECT_EQ(resolve_interface("usb:1-2", sys_), "can1");
}

TEST_F(InterfaceName, FormsAreChecked) {
  for (const char* good :
       {"can0", "usb:1-2", "usb:1-2.3.4", "usb:12-2/1", "serial:00 11", "serial:A/B"}) {
    EXPECT_EQ(wrong_interface_name(good), "") << good;
  }
  for (const char* bad : {"", "usb:", "usb:1", "usb:1-", "usb:1-2.", "usb:a-2",
                          "serial:", "serial:/1", "can0/1", "a-name-of-more-than-15", "can 0"}) {
    EXPECT_NE(wrong_interface_name(bad), "") << bad;
  }
}

}  // namespace
}  // namespace geodesic::drivers
