// The control socket's server side: listening, clients, bounded buffers.
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "drivers/bus/descriptor.hpp"
#include "tools/geodesicd/control_address.hpp"
#include "tools/geodesicd/control_peer.hpp"
#include "tools/geodesicd/control_socket.hpp"

namespace geodesic::tools {
namespace {

using Clock = std::chrono::steady_clock;
using drivers::Descriptor;
using drivers::UnixAddress;

[[noreturn]] void fail(const std::string& attempted, const std::filesystem::path& path,
                       const std::string& fix) {
  const int number = errno;
  throw ControlError(attempted + " " + path.string() + ": " + std::strerror(number) + "; " + fix);
}

constexpr const char* kChoose = "choose another path by --socket PATH";

/// In a folder that others may write (like /tmp), a folder of that name could be somebody's trap.
void make_folder(const std::filesystem::path& folder) {
  if (::mkdir(folder.c_str(), 0750) == 0) {
    return;
  }
  if (errno != EEXIST) {
    fail("cannot make the control socket's folder", folder, kChoose);
  }
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) {
    throw ControlError("the control socket's folder " + folder.string() + " is not a folder; " +
                       kChoose);
  }
  if ((status.st_mode & S_IWOTH) != 0 && (status.st_mode & S_ISVTX) == 0) {
    throw ControlError("anybody may replace files in the control socket's folder " +
                       folder.string() + "; chmod o-w it, or " + kChoose);
  }
}

/// Only a folder of our own making must be ours; --socket may name any.
void check_owner(const std::filesystem::path& folder) {
  if (folder.filename().string().rfind("geodesic-", 0) != 0) {
    return;
  }
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) ||
      status.st_uid != ::geteuid() || (status.st_mode & 0022U) != 0) {
    throw ControlError("the control socket's folder " + folder.string() +
                       " is not a folder that belongs to this user and that nobody else may "
                       "write; remove it, or " +
                       kChoose);
  }
}

/// Removes a socket that nobody serves any more.
void clear_the_way(const std::filesystem::path& path, const UnixAddress& address) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) {
    return;
  }
  if (!S_ISSOCK(status.st_mode)) {
    throw ControlError(path.string() + " exists and is not a socket; remove it, or " + kChoose);
  }
  const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const bool connected = ::connect(probe.get(), address.get(), address.size()) == 0;
  if (connected || errno == EAGAIN) {
    ucred peer{};
    socklen_t size = sizeof(peer);
    const bool known =
        connected && ::getsockopt(probe.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0;
    throw ControlError("a daemon for this robot is already running" +
                       (known ? " (pid " + std::to_string(peer.pid) + ")" : std::string()) +
                       " and serves " + path.string() + "; stop it by `geodesic stop --exit`");
  }
  if (errno != ECONNREFUSED) {
    fail("cannot tell whether a daemon serves", path, kChoose);
  }
  ::unlink(path.c_str());
}

/// Binds and listens. The socket never is, not even for a moment, open to more than owner and
/// group: it is bound with that mode, and nobody can connect before listen().
Descriptor listening(const std::filesystem::path& path, const UnixAddress& address, int backlog) {
  Descriptor listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!listener.valid()) {
    fail("cannot open a socket for", path, "raise the limit of open files (ulimit -n)");
  }
  // Linux binds with the mode that the unbound socket has, less the umask.
  if (::fchmod(listener.get(), 0660) != 0 ||
      ::bind(listener.get(), address.get(), address.size()) != 0) {
    fail("cannot bind the control socket", path, kChoose);
  }
  // What the umask took from the group is given back, and only ever to a socket: the name could
  // have been replaced by a link.
  struct stat status {};
  const bool whole = ::lstat(path.c_str(), &status) == 0 && (status.st_mode & 0777U) == 0660U;
  if ((!whole && ::fchmodat(AT_FDCWD, path.c_str(), 0660, AT_SYMLINK_NOFOLLOW) != 0) ||
      ::listen(listener.get(), backlog) != 0) {
    const int number = errno;
    ::unlink(path.c_str());
    errno = number;
    fail("cannot listen on the control socket", path, kChoose);
  }
  return listener;
}

struct Client {
  Descriptor socket;
  std::string input;
  std::string output;
  std::size_t sent = 0;  ///< of output
  Clock::time_point heard;
  Clock::time_point began;    ///< when the first byte of the request in `input` came
  Clock::time_point drained;  ///< when output was last empty or moved
  bool more = false;          ///< whole requests wait for the next round
  bool closing = false;       ///< to be dropped once output has left
  bool gone = false;
};

}  // namespace

struct ControlServer::Impl {
  std::filesystem::path path;
  ControlPatience patience;
  gid_t group = 0;  ///< of the socket: its members may ask
  Descriptor listener;
  Clock::time_point no_room_until;  ///< no descriptors left: nobody is accepted before
  std::vector<Client> clients;

  void accept_all();
  bool make_room();
  static void read(Client& client);
  static void answer_lines(Client& client, const Handler& answer);
  static void write(Client& client);
  void judge(Client& client) const;
};

ControlServer::ControlServer(const std::filesystem::path& path, const ControlPatience& patience)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->patience = patience;
  impl_->clients.reserve(kMaxClients);
  const UnixAddress address = control_address(path);
  const std::filesystem::path folder =
      path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  make_folder(folder);
  check_owner(folder);
  clear_the_way(path, address);

  impl_->listener = listening(path, address, kMaxClients);
  struct stat status {};
  impl_->group = ::lstat(path.c_str(), &status) == 0 ? status.st_gid : ::getegid();
}

ControlServer::~ControlServer() {
  ::unlink(impl_->path.c_str());
}

const std::filesystem::path& ControlServer::path() const noexcept {
  return impl_->path;
}

std::size_t ControlServer::clients() const noexcept {
  return impl_->clients.size();
}

void ControlServer::serve(std::chrono::milliseconds wait, const Handler& answer) {
  std::array<pollfd, kMaxClients + 1> waiting{};
  const bool room_for_more = Clock::now() >= impl_->no_room_until;
  waiting[0] = {room_for_more ? impl_->listener.get() : -1, POLLIN, 0};
  std::size_t count = 1;
  bool more = false;
  for (const Client& client : impl_->clients) {
    const bool room = !client.closing && client.input.size() < kMaxRequest;
    const auto interest =
        static_cast<short>((room ? POLLIN : 0) | (client.output.empty() ? 0 : POLLOUT));
    waiting[count++] = {client.socket.get(), interest, 0};
    more = more || client.more;
  }
  ::poll(waiting.data(), count, more ? 0 : static_cast<int>(wait.count()));

  for (std::size_t i = 0; i + 1 < count; ++i) {
    Client& client = impl_->clients[i];
    if ((waiting[i + 1].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
      Impl::read(client);
    }
    Impl::answer_lines(client, answer);
    Impl::write(client);
    impl_->judge(client);
  }
  std::erase_if(impl_->clients, [](const Client& client) { return client.gone; });
  if ((waiting[0].revents & POLLIN) != 0) {
    impl_->accept_all();
  }
}

void ControlServer::Impl::accept_all() {
  constexpr std::string_view kFull =
      "{\"ok\":false,\"error\":\"the daemon already serves as many clients as it can (8)\"}\n";
  constexpr std::string_view kStranger =
      "{\"ok\":false,\"error\":\"only the daemon's user and its group may ask it\"}\n";
  constexpr std::chrono::milliseconds kNoRoom{200};
  const auto turn_away = [](const Descriptor& socket, std::string_view why) {
    (void)::send(socket.get(), why.data(), why.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  };
  for (std::size_t i = 0; i < kMaxClients; ++i) {
    Descriptor socket(::accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!socket.valid()) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS) {
        // Whoever waits stays readable: without a pause this thread would do nothing else.
        no_room_until = Clock::now() + kNoRoom;
      }
      return;
    }
    const std::optional<ControlPeer> peer = control_peer(socket.get());
    if (!peer || !may_ask(*peer, ::geteuid(), group)) {
      turn_away(socket, kStranger);
      continue;
    }
    if (clients.size() == kMaxClients && !make_room()) {
      turn_away(socket, kFull);
      continue;
    }
    Client client;
    client.socket = std::move(socket);
    client.heard = client.began = client.drained = Clock::now();
    clients.push_back(std::move(client));
  }
}

/// Forgotten connections must not keep somebody from asking for a stop.
bool ControlServer::Impl::make_room() {
  const auto oldest =
      std::min_element(clients.begin(), clients.end(),
                       [](const Client& a, const Client& b) { return a.heard < b.heard; });
  if (Clock::now() - oldest->heard < patience.crowded) {
    return false;
  }
  clients.erase(oldest);
  return true;
}

void ControlServer::Impl::read(Client& client) {
  if (client.closing) {
    client.gone = true;  // hung up before it read our last word
    return;
  }
  std::array<char, kMaxRequest> bytes;
  const std::size_t room = kMaxRequest - client.input.size();
  if (room == 0) {
    client.gone = true;  // hung up while its requests waited for their answers to be read
    return;
  }
  const ssize_t got = ::recv(client.socket.get(), bytes.data(), room, 0);
  if (got > 0) {
    client.heard = Clock::now();
    if (client.input.empty()) {
      client.began = client.heard;
    }
    client.input.append(bytes.data(), static_cast<std::size_t>(got));
  } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
    client.closing = true;
  }
}

void ControlServer::Impl::answer_lines(Client& client, const Handler& answer) {
  std::size_t begin = 0;
  std::size_t answers = 0;
  const auto room = [&client] { return client.output.size() - client.sent < kMaxPending / 2; };
  while (answers < kMaxAnswers && room()) {
    const std::size_t end = client.input.find('\n', begin);
    if (end == std::string::npos) {
      break;
    }
    client.output += answer(std::string_view(client.input).substr(begin, end - begin));
    client.output += '\n';
    begin = end + 1;
    ++answers;
  }
  if (begin > 0) {
    client.input.erase(0, begin);
    client.began = Clock::now();
  }
  if (client.input.size() == kMaxRequest && client.input.find('\n') == std::string::npos) {
    client.output += "{\"ok\":false,\"error\":\"request longer than " +
                     std::to_string(kMaxRequest) + " bytes\"}\n";
    client.input.clear();
    client.closing = true;
  }
}

void ControlServer::Impl::write(Client& client) {
  if (client.output.empty()) {
    client.drained = Clock::now();
    return;
  }
  const ssize_t sent = ::send(client.socket.get(), client.output.data() + client.sent,
                              client.output.size() - client.sent, MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent > 0) {
    client.sent += static_cast<std::size_t>(sent);
    client.drained = Clock::now();
    if (client.sent == client.output.size()) {
      client.output.clear();
      client.sent = 0;
    }
  } else if (sent < 0 && errno != EAGAIN && errno != EINTR) {
    client.gone = true;
  }
}

void ControlServer::Impl::judge(Client& client) const {
  const Clock::time_point now = Clock::now();
  client.more = client.output.size() - client.sent < kMaxPending / 2 &&
                client.input.find('\n') != std::string::npos;
  const bool unfinished = !client.input.empty() && client.output.empty() && !client.more;
  if ((client.closing && client.output.empty() && !client.more) ||
      now - client.drained > patience.unread || now - client.heard > patience.silent ||
      (unfinished && now - client.began > patience.unfinished) ||
      client.output.size() - client.sent > kMaxPending) {
    client.gone = true;
  }
}

}  // namespace geodesic::tools
