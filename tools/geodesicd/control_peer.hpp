// Who may ask the daemon: the rule, and who is at the other end of a socket. Nothing is answered
// here.
#pragma once

#include <sys/types.h>

#include <optional>
#include <vector>

namespace geodesic::tools {

/// Who is at the other end, as the kernel vouches: its credentials when it connected.
struct ControlPeer {
  uid_t uid = 0;
  std::vector<gid_t> groups;  ///< primary and supplementary
};

/// Nothing if the kernel does not tell.
std::optional<ControlPeer> control_peer(int socket);

/// The daemon's own user, root, and members of the socket's group. The socket's mode says the same;
/// this holds as well where somebody has opened the mode up.
bool may_ask(const ControlPeer& peer, uid_t owner, gid_t group);

}  // namespace geodesic::tools
