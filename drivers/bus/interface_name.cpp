// From how people name an interface to the kernel's name of it, by what /sys says. The layout:
// Documentation/ABI/testing/sysfs-class-net and sysfs-bus-usb of the kernel.
#include "drivers/bus/interface_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <system_error>
#include <tuple>

#include "drivers/bus/bus.hpp"

namespace geodesic::drivers {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUsb = "usb:";
constexpr std::string_view kSerial = "serial:";
constexpr std::size_t kLongestName = 15;  // IFNAMSIZ with its NUL
constexpr int kCanType = 280;             // ARPHRD_CAN

struct Wanted {
  std::string_view usb;
  std::string_view serial;
  std::optional<int> channel;
};

std::string first_line(const fs::path& file) {
  std::string line;
  std::ifstream stream(file);
  std::getline(stream, line);
  return line;
}

/// Decimal, or hexadecimal with 0x; 0 where there is none.
int number_in(const fs::path& file) {
  const std::string text = first_line(file);
  std::string_view digits = text;
  const int base = digits.starts_with("0x") ? 16 : 10;
  digits.remove_prefix(base == 16 ? 2 : 0);
  int value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
  return value;
}

bool all_digits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// "1-2.3": bus, dash, ports with dots between them.
bool is_usb_path(std::string_view text) {
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos || !all_digits(text.substr(0, dash))) {
    return false;
  }
  std::string_view ports = text.substr(dash + 1);
  for (;;) {
    const std::size_t dot = ports.find('.');
    if (!all_digits(ports.substr(0, dot))) {
      return false;
    }
    if (dot == std::string_view::npos) {
      return true;
    }
    ports.remove_prefix(dot + 1);
  }
}

std::optional<Wanted> by_place(std::string_view name) {
  Wanted wanted;
  const bool usb = name.starts_with(kUsb);
  if (!usb && !name.starts_with(kSerial)) {
    return std::nullopt;
  }
  std::string_view value = name.substr(usb ? kUsb.size() : kSerial.size());
  const std::size_t slash = value.rfind('/');
  if (slash != std::string_view::npos && all_digits(value.substr(slash + 1)) &&
      value.size() - slash <= 3) {
    int channel = 0;
    std::from_chars(value.data() + slash + 1, value.data() + value.size(), channel);
    wanted.channel = channel;
    value = value.substr(0, slash);
  }
  (usb ? wanted.usb : wanted.serial) = value;
  return wanted;
}

/// One interface with what orders the channels of an adapter.
struct Found {
  AdapterPlace place;
  std::tuple<std::string, int, int, int> order;
};

Found look_at(const fs::path& entry) {
  Found found;
  found.place.device = entry.filename().string();
  std::error_code none;
  std::string function;
  fs::path device = fs::canonical(entry / "device", none);
  if (!none) {
    function = device.filename().string();
    for (; device.has_relative_path(); device = device.parent_path()) {
      // The adapter itself is named by its path and has what only whole USB devices have.
      if (is_usb_path(device.filename().string()) && fs::exists(device / "idVendor", none)) {
        found.place.usb = device.filename().string();
        found.place.serial = first_line(device / "serial");
        break;
      }
    }
  }
  found.order = {function, number_in(entry / "dev_port"), number_in(entry / "dev_id"),
                 number_in(entry / "ifindex")};
  return found;
}

std::string text_of(const AdapterPlace& place) {
  std::string text = place.device;
  if (!place.usb.empty()) {
    text += fmt::format(" is usb:{}/{}", place.usb, place.channel);
  }
  if (!place.serial.empty()) {
    text += fmt::format(", serial:{}/{}", place.serial, place.channel);
  }
  return text;
}

std::string list_of(const std::vector<AdapterPlace>& places) {
  std::string list;
  for (const AdapterPlace& place : places) {
    list += fmt::format("{}{}", list.empty() ? "" : "; ", text_of(place));
  }
  return list.empty() ? std::string("there is no CAN interface at all") : list;
}

}  // namespace

std::string wrong_interface_name(std::string_view name) {
  if (const auto wanted = by_place(name)) {
    if (name.starts_with(kUsb) && !is_usb_path(wanted->usb)) {
      return "expected bus and ports after usb:, as in usb:1-2.3, or usb:1-2.3/1 for its second "
             "channel";
    }
    if (name.starts_with(kSerial) && wanted->serial.empty()) {
      return "expected the adapter's serial number after serial:, as `geodesic scan` or "
             "/sys/bus/usb/devices/*/serial have it";
    }
    return {};
  }
  if (name.empty() || name.size() > kLongestName ||
      name.find_first_of("/ \t:") != std::string_view::npos) {
    return "expected the name of a network interface such as can0 (at most 15 letters), usb:PATH, "
           "serial:NUMBER, or unix:PATH";
  }
  return {};
}

std::vector<AdapterPlace> can_adapters(const fs::path& sys) {
  std::vector<Found> all;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(sys / "class/net", none)) {
    if (number_in(entry.path() / "type") == kCanType) {
      all.push_back(look_at(entry.path()));
    }
  }
  std::sort(all.begin(), all.end(), [](const Found& a, const Found& b) {
    return std::tie(a.place.usb, a.order, a.place.device) <
           std::tie(b.place.usb, b.order, b.place.device);
  });
  std::vector<AdapterPlace> places;
  for (Found& found : all) {
    const bool same =
        !places.empty() && !found.place.usb.empty() && places.back().usb == found.place.usb;
    found.place.channel = same ? places.back().channel + 1 : 0;
    places.push_back(std::move(found.place));
  }
  return places;
}

std::string resolve_interface(const std::string& name, const fs::path& sys) {
  const auto wanted = by_place(name);
  if (!wanted) {
    return name;
  }
  const std::vector<AdapterPlace> all = can_adapters(sys);
  std::vector<AdapterPlace> meant;
  std::copy_if(all.begin(), all.end(), std::back_inserter(meant), [&](const AdapterPlace& place) {
    const bool here =
        wanted->usb.empty() ? place.serial == wanted->serial : place.usb == wanted->usb;
    return here && place.channel == wanted->channel.value_or(place.channel);
  });
  if (meant.size() == 1) {
    return meant.front().device;
  }
  if (meant.empty()) {
    throw BusError(fmt::format("no CAN interface at {}; those that are there: {}; fix: plug the "
                               "adapter in there, or name another",
                               name, list_of(all)),
                   ENODEV);
  }
  throw BusError(fmt::format("{} has {} CAN channels: {}; fix: say which, as in {}/0", name,
                             meant.size(), list_of(meant), name),
                 ENOTUNIQ);
}

}  // namespace geodesic::drivers
