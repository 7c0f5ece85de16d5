// The daemon's control socket: the server that the service thread polls, and the client that
// `geodesic status`, `law` and `stop` use. Lines of JSON either way; what they mean is in
// requests.hpp.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

#include "drivers/bus/descriptor.hpp"
#include "tools/geodesicd/control_path.hpp"

namespace geodesic::tools {

/// What went wrong with a control socket, in words for people, with the path and what helps.
class ControlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How long clients may take their time. The defaults are the daemon's.
struct ControlPatience {
  std::chrono::milliseconds unread{2000};      ///< answers that nobody reads are kept so long
  std::chrono::milliseconds unfinished{5000};  ///< a request that has begun must end within
  std::chrono::milliseconds silent{60000};     ///< clients that ask nothing are kept so long,
  std::chrono::milliseconds crowded{5000};     ///< or so long if others want their place
};

/// Answers up to kMaxClients at a time without ever waiting for one of them. What a client may cost
/// in one round is bounded: the bytes read, the requests answered, the bytes kept for it. One that
/// stays stuck is dropped.
class ControlServer {
 public:
  static constexpr std::size_t kMaxClients = 8;
  static constexpr std::size_t kMaxRequest = 4096;        ///< [bytes], newline included
  static constexpr std::size_t kMaxPending = 256 * 1024;  ///< [bytes] not read by a client
  static constexpr std::size_t kMaxAnswers = 16;          ///< to one client in one round

  /// One request line without its newline -> one answer line without its newline. Must not throw.
  using Handler = std::function<std::string(std::string_view)>;

  /// Makes the folder (0750) if need be and listens (0660): for its owner, its group and root,
  /// whose credentials are asked of the kernel as well. A socket that nobody serves any more is
  /// replaced.
  /// @throws ControlError if a daemon already serves this path (with its pid), the folder belongs
  /// to somebody else or may be written by all, or the path is too long.
  explicit ControlServer(const std::filesystem::path& path, const ControlPatience& patience = {});
  /// Closes all and removes the socket.
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  /// Waits up to `wait` for somebody to say something, then serves all who did.
  void serve(std::chrono::milliseconds wait, const Handler& answer);

  const std::filesystem::path& path() const noexcept;
  std::size_t clients() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One connection to a daemon.
class ControlClient {
 public:
  /// @throws ControlError if no daemon serves `path`, or it may not be reached.
  explicit ControlClient(const std::filesystem::path& path,
                         std::chrono::milliseconds timeout = std::chrono::seconds(2));

  /// Sends {"cmd": ...} and returns the daemon's answer, which holds "ok" and, if false, "error".
  /// @throws ControlError if no whole answer comes within the time-out.
  nlohmann::json request(const nlohmann::json& request);

 private:
  std::string read_line();

  std::filesystem::path path_;
  std::chrono::milliseconds timeout_;
  std::string received_;
  drivers::Descriptor socket_;
};

/// Where the daemon of `robot` can be reached: `chosen` if not empty, else the first candidate of
/// control_path_candidates() on which somebody listens, else the one a daemon would choose.
std::filesystem::path find_control_socket(const std::string& robot,
                                          const std::filesystem::path& chosen = {});

}  // namespace geodesic::tools
