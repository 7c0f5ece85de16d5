// From how people name an interface to the kernel's name of it: by itself, by the USB socket it is
// plugged into, or by the adapter's serial number. Reads /sys alone; opens nothing. Not real-time.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace geodesic::drivers {

/// A CAN interface and where it is plugged in.
struct AdapterPlace {
  std::string device;  ///< "can0"
  std::string usb;  ///< "1-2.3": bus 1, port 2 of its root hub, port 3 of the hub there; or empty
  std::string serial;  ///< of the USB adapter; empty: it has none, or is on no USB
  int channel = 0;     ///< among the interfaces of one USB adapter, counted from 0
};

/// Whether a name has the form of one: "can0" (at most 15 characters), "usb:1-2.3", "serial:ABC",
/// either of these with "/CHANNEL". @return what is wrong with it, or empty.
std::string wrong_interface_name(std::string_view name);

/// All CAN interfaces, in order of USB path, channel and name. @param sys  where sysfs is mounted
std::vector<AdapterPlace> can_adapters(const std::filesystem::path& sys = "/sys");

/// The kernel's name: a plain name is returned as it is, whether there is such an interface or not.
/// @throws BusError naming the adapters that there are, if none or several are meant.
std::string resolve_interface(const std::string& name, const std::filesystem::path& sys = "/sys");

}  // namespace geodesic::drivers
