// A socket bus that is held still for a second, and remote frames on it; the same for the kernel's
// interfaces: vcan_link_test, kvaser_test.
#include <filesystem>
#include <optional>

#include "drivers/bus/socket_bus_hub.hpp"
#include "tests/drivers/bus/held_bus.hpp"

namespace geodesic::drivers {
namespace {

namespace fs = std::filesystem;
using testing::HeldBus;
using testing::hold_for_a_second;
using testing::ids;
using testing::kMillisecond;
using testing::make_frame;
using testing::receive;

// NOLINTNEXTLINE(cppcoreguidelines-virtual-class-destructor)
class HeldSocketBus : public ::testing::Test {
 protected:
  HeldSocketBus() {
    std::string name = (fs::temp_directory_path() / "geodesic-held-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~HeldSocketBus() override { fs::remove_all(folder_); }

  void serve(bool paced) { hub_.emplace(SocketBusHubOptions{.path = path(), .paced = paced}); }
  std::string path() const { return (folder_ / "bus").string(); }
  std::unique_ptr<Bus> connect(const std::vector<IdFilter>& in, const std::vector<IdFilter>& out) {
    BusOptions options;
    options.interface = "unix:" + path();
    options.receive = in;
    options.transmit = out;
    return open_bus(options);
  }

  fs::path folder_;
  std::optional<SocketBusHub> hub_;
};

// Neither what waited in the hub nor what stood half on the wire.
TEST_F(HeldSocketBus, ForASecondItDeliversNoOldCommand) {
  for (const bool paced : {false, true}) {
    serve(paced);
    const auto host = connect(ids(0x11, 8), ids(0x01, 8));
    const auto drive = connect({}, {});
    const HeldBus result =
        hold_for_a_second(*host, *drive, [this](bool held) { hub_->hold(held); });
    EXPECT_GE(result.arrived_before, 50U);
    EXPECT_GE(result.arrived_after, 50U);
    EXPECT_LT(result.oldest_ns, 25 * kMillisecond + result.longest_pause_ns);
    EXPECT_FALSE(host->state().stalled);
    EXPECT_FALSE(host->state().down);
  }
}

TEST_F(HeldSocketBus, RemoteFramesCrossWithoutData) {
  serve(false);
  const auto a = connect({}, {});
  const auto b = connect({}, {});
  Frame remote = make_frame(0x123);
  remote.remote = true;
  remote.length = 8;
  const std::vector<Frame> frames = {remote, make_frame(0x123, {1, 2})};
  ASSERT_EQ(a->send(frames), 2U);
  const auto got = receive(*b, 2);
  ASSERT_EQ(got.size(), 2U);
  EXPECT_EQ(got[0].frame, frames[1]) << "of equal identifiers data comes first";
  EXPECT_EQ(got[1].frame, remote);
}

}  // namespace
}  // namespace geodesic::drivers
