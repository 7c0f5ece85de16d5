// A CAN interface as the kernel describes and changes it: netlink messages to and from structs.
// What is wanted of an interface, and what is done about it, live in link_plan and link_setup. Not
// real-time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/bus/link_health.hpp"
#include "drivers/bus/netlink.hpp"

namespace geodesic::drivers {

/// Of one phase; what the kernel does not tell is empty (vcan has none of it).
struct LinkTiming {
  std::optional<std::int64_t> bit_rate;  ///< [bit/s]
  std::optional<double> sample_point;    ///< part of the bit, 0..1
  int quanta = 0;                        ///< a bit has so many; 0: not told
};

struct CanLink {
  int index = 0;
  std::string name;
  std::string kind;  ///< "can", "vcan", "vxcan"; of slcan and the like empty with old kernels
  bool can = false;  ///< it is a CAN interface at all
  bool up = false;
  bool echoes = false;  ///< gives our own frames back once they have left
  int mtu = 0;          ///< [bytes]; 72: CAN FD
  int queue = 0;        ///< [frames], txqueuelen
  LinkTiming nominal;
  LinkTiming data;
  bool fd = false;                       ///< set to CAN FD (controllers); carries it (virtual ones)
  std::optional<int> restart_ms;         ///< after a bus-off; 0: never by itself
  std::optional<LinkHealth> controller;  ///< state and error counters, where it has a controller
  std::uint64_t received = 0;            ///< frames on the wire from others, since it was made
  std::uint64_t sent = 0;

  bool has_controller() const { return controller.has_value(); }
};

/// What to change; what is empty stays as it is.
struct LinkChange {
  std::optional<bool> up;
  std::optional<int> mtu;
  std::optional<int> queue;
  /// The controller's: only while it is down.
  std::optional<std::int64_t> bit_rate;
  std::optional<double> sample_point;
  std::optional<bool> fd;
  std::optional<std::int64_t> data_bit_rate;
  std::optional<double> data_sample_point;
  std::optional<int> restart_ms;

  bool touches_controller() const {
    return bit_rate || sample_point || fd || data_bit_rate || data_sample_point || restart_ms;
  }
};

/// @return nothing if the message is none about a link (RTM_NEWLINK). Survives any bytes.
std::optional<CanLink> parse_can_link(const NetlinkMessage& message);

/// A question for one interface by name.
std::vector<std::byte> ask_link_message(const std::string& name, std::uint32_t sequence);
/// A question for all of them.
std::vector<std::byte> ask_links_message(std::uint32_t sequence);
std::vector<std::byte> change_link_message(int index, const LinkChange& change,
                                           std::uint32_t sequence);

/// The kernel's interfaces, or a test's.
class LinkPort {
 public:
  virtual ~LinkPort() = default;
  /// @return nothing if there is none of that name; `error` then is errno (ENODEV) .
  virtual std::optional<CanLink> read(const std::string& name, int& error) = 0;
  virtual NetlinkVerdict change(int index, const LinkChange& change) = 0;

 protected:
  LinkPort() = default;
  LinkPort(const LinkPort&) = default;
  LinkPort& operator=(const LinkPort&) = default;
};

/// By rtnetlink. change() needs CAP_NET_ADMIN.
class KernelLinkPort final : public LinkPort {
 public:
  std::optional<CanLink> read(const std::string& name, int& error) override;
  NetlinkVerdict change(int index, const LinkChange& change) override;
  /// All CAN interfaces there are, in order of index.
  std::vector<CanLink> all();

 private:
  RouteSocket socket_;
};

}  // namespace geodesic::drivers
