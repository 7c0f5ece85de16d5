// Who may ask the daemon; see control_peer.hpp. Source: socket(7), unix(7): SO_PEERCRED,
// SO_PEERGROUPS.
#include "tools/geodesicd/control_peer.hpp"

#include <sys/socket.h>

#include <algorithm>

namespace geodesic::tools {

std::optional<ControlPeer> control_peer(int socket) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) {
    return std::nullopt;
  }
  ControlPeer peer{credentials.uid, std::vector<gid_t>(64)};
  size = static_cast<socklen_t>(peer.groups.size() * sizeof(gid_t));
  // More groups than that (ERANGE), or a kernel that does not tell: the primary group alone counts.
  const bool told = ::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, peer.groups.data(), &size) == 0;
  peer.groups.resize(told ? size / sizeof(gid_t) : 0);
  peer.groups.push_back(credentials.gid);
  return peer;
}

bool may_ask(const ControlPeer& peer, uid_t owner, gid_t group) {
  return peer.uid == 0 || peer.uid == owner ||
         std::find(peer.groups.begin(), peer.groups.end(), group) != peer.groups.end();
}

}  // namespace geodesic::tools
