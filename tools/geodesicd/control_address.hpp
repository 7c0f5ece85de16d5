// The address of a control socket's path, or an error for people. Internal to the control socket.
#pragma once

#include <filesystem>
#include <string>

#include "drivers/bus/unix_address.hpp"
#include "tools/geodesicd/control_socket.hpp"

namespace geodesic::tools {

/// @throws ControlError if the path does not fit into an address.
inline drivers::UnixAddress control_address(const std::filesystem::path& path) {
  const auto address = drivers::UnixAddress::path(path.string());
  if (!address) {
    throw ControlError("the control socket's path has " + std::to_string(path.native().size()) +
                       " bytes, the kernel takes 1 to 107: " + path.string() +
                       "; choose another by --socket PATH");
  }
  return *address;
}

}  // namespace geodesic::tools
