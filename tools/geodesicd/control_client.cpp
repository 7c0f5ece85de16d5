// The control socket's client side, as the command line uses it.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "drivers/bus/descriptor.hpp"
#include "tools/geodesicd/control_address.hpp"
#include "tools/geodesicd/control_socket.hpp"

namespace geodesic::tools {

using drivers::Descriptor;
using drivers::UnixAddress;

namespace {

/// Invalid and errno if nobody serves `path`.
Descriptor connected(const UnixAddress& address) {
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (socket.valid() && ::connect(socket.get(), address.get(), address.size()) != 0) {
    const int number = errno;
    socket.reset();
    errno = number;
  }
  return socket;
}

}  // namespace

ControlClient::ControlClient(const std::filesystem::path& path, std::chrono::milliseconds timeout)
    : path_(path), timeout_(timeout), socket_(connected(control_address(path))) {
  if (socket_.valid()) {
    return;
  }
  const int number = errno;
  if (number == EACCES || number == EPERM) {
    throw ControlError("may not reach the daemon at " + path.string() +
                       ": only its owner and its group may; join the group, or run this as the "
                       "daemon's user");
  }
  if (number == ENOENT || number == ECONNREFUSED) {
    throw ControlError("no daemon serves " + path.string() +
                       "; start it by `geodesicd ROBOT.toml`, or name its socket by --socket PATH");
  }
  throw ControlError("cannot reach the daemon at " + path.string() + ": " + std::strerror(number));
}

nlohmann::json ControlClient::request(const nlohmann::json& request) {
  const std::string line = request.dump() + '\n';
  std::size_t sent = 0;
  while (sent < line.size()) {
    const ssize_t count =
        ::send(socket_.get(), line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count < 0) {
      throw ControlError("the daemon at " + path_.string() + " hung up: " + std::strerror(errno));
    }
    sent += static_cast<std::size_t>(count);
  }
  const std::string answer = read_line();
  nlohmann::json parsed = nlohmann::json::parse(answer, nullptr, false);
  if (!parsed.is_object()) {
    throw ControlError("what serves " + path_.string() +
                       " does not answer as geodesicd does: " + answer.substr(0, 80));
  }
  return parsed;
}

std::string ControlClient::read_line() {
  const auto deadline = std::chrono::steady_clock::now() + timeout_;
  while (true) {
    if (const std::size_t end = received_.find('\n'); end != std::string::npos) {
      std::string line = received_.substr(0, end);
      received_.erase(0, end + 1);
      return line;
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    pollfd waiting{socket_.get(), POLLIN, 0};
    const int ready = ::poll(&waiting, 1, std::max(0, static_cast<int>(left.count())));
    if (ready < 0 && errno == EINTR) {
      continue;
    }
    if (ready <= 0) {
      throw ControlError("the daemon at " + path_.string() + " did not answer within " +
                         std::to_string(timeout_.count()) + " ms");
    }
    std::array<char, 16384> bytes;
    const ssize_t got = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    if (got < 0 && errno == EINTR) {
      continue;
    }
    if (got <= 0) {
      throw ControlError("the daemon at " + path_.string() + " hung up before it answered");
    }
    received_.append(bytes.data(), static_cast<std::size_t>(got));
  }
}

std::filesystem::path find_control_socket(const std::string& robot,
                                          const std::filesystem::path& chosen) {
  if (!chosen.empty()) {
    return chosen;
  }
  const PathEnvironment environment = PathEnvironment::current();
  for (const std::filesystem::path& path : control_path_candidates(robot, environment)) {
    const auto address = UnixAddress::path(path.string());
    if (address && connected(*address).valid()) {
      return path;
    }
  }
  return control_path(robot, environment);
}

}  // namespace geodesic::tools
