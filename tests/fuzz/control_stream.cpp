// Fuzz target: the control socket with up to three clients that send, stall, half-close, do not
// read and leave, in any order.
#include <sys/socket.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "drivers/bus/descriptor.hpp"
#include "drivers/bus/unix_address.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tools/geodesicd/control_socket.hpp"
#include "tools/geodesicd/requests.hpp"

namespace geodesic::fuzz {
namespace {

using drivers::Descriptor;
using tools::ControlServer;

struct Peer {
  Descriptor socket;
  std::size_t lines = 0;       ///< whole ones, sent
  std::size_t unfinished = 0;  ///< bytes behind the last of them
  bool too_long = false;       ///< a line was longer than a request may be
  std::string received;
};

class Bench {
 public:
  Bench() : server_(scratch_folder() / "control.sock") {
    actions_.status = [] {
      return nlohmann::ordered_json{{"ok", true}, {"padding", std::string(3000, 'x')}};
    };
    actions_.hand_over = [](const control::Request&) { return true; };
    actions_.exit = [] {};
    actions_.ending = [] { return false; };
  }

  void serve() {
    server_.serve(std::chrono::milliseconds(0), [this](std::string_view line) {
      expect(line.size() < ControlServer::kMaxRequest, "no request is longer than allowed");
      expect(line.find('\n') == std::string_view::npos, "a request is one line");
      ++answered_;
      return tools::answer_request(line, actions_);
    });
    expect(server_.clients() <= ControlServer::kMaxClients, "never more clients than allowed");
  }

  void connect(Peer& peer) {
    peer = Peer{};
    peer.socket = Descriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto address = drivers::UnixAddress::path(server_.path().string());
    // A full backlog refuses; serving makes room.
    if (::connect(peer.socket.get(), address->get(), address->size()) != 0) peer.socket.reset();
  }

  static void send(Peer& peer, std::string_view text) {
    if (!peer.socket.valid()) return;
    const ssize_t sent =
        ::send(peer.socket.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    for (ssize_t i = 0; i < sent; ++i) {
      const bool end = text[static_cast<std::size_t>(i)] == '\n';
      peer.lines += end ? 1U : 0U;
      peer.unfinished = end ? 0U : peer.unfinished + 1U;
      peer.too_long = peer.too_long || peer.unfinished >= ControlServer::kMaxRequest;
    }
  }

  static void receive(Peer& peer) {
    std::array<char, 65536> bytes;
    if (!peer.socket.valid()) return;
    const ssize_t got = ::recv(peer.socket.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got > 0) peer.received.append(bytes.data(), static_cast<std::size_t>(got));
  }

  /// Reads what is still to come, then holds every answer against what was asked.
  void finish(Peer& peer) {
    if (!peer.socket.valid()) return;
    std::size_t before = peer.received.size() + 1;
    for (int quiet = 0; quiet < 3;) {
      serve();
      receive(peer);
      quiet = peer.received.size() == before ? quiet + 1 : 0;
      before = peer.received.size();
    }
    std::size_t answers = 0;
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = peer.received.find('\n', begin)) != std::string::npos;) {
      const auto answer =
          nlohmann::json::parse(peer.received.begin() + static_cast<long>(begin),
                                peer.received.begin() + static_cast<long>(end), nullptr, false);
      expect(answer.is_object() && answer.contains("ok"), "every answer is one JSON line");
      ++answers;
      begin = end + 1;
    }
    expect(begin == peer.received.size(), "no answer is left half");
    expect(answers <= peer.lines + (peer.too_long ? 1U : 0U), "no answer without a request");
    expect(peer.too_long || answers == peer.lines,
           "every request of a client that reads is answered");
    peer.socket.reset();
  }

  /// All clients have gone: so they have for the server.
  void drain() {
    for (int i = 0; i < 4; ++i) serve();  // some may not have been let in yet
    for (int i = 0; i < 8 && server_.clients() > 0; ++i) serve();
    expect(server_.clients() == 0, "who has left is forgotten");
  }

 private:
  ControlServer server_;
  tools::RequestActions actions_;
  std::size_t answered_ = 0;
};

}  // namespace

void control_stream(Bytes bytes) {
  static Bench bench;
  Input input(bytes);
  std::array<Peer, 3> peers;
  while (!input.empty()) {
    Peer& peer = peers[input.below(peers.size())];
    switch (input.below(8)) {
      case 0:
        peer.socket.reset();
        break;
      case 1:
        if (peer.socket.valid()) ::shutdown(peer.socket.get(), SHUT_WR);
        break;
      case 2:
        Bench::receive(peer);
        break;
      case 3:
        bench.serve();
        break;
      case 4:
        Bench::send(peer, std::string(input.integer(2) % 5000U, 'x'));
        break;
      default:
        if (!peer.socket.valid()) {
          bench.serve();
          bench.connect(peer);
        }
        Bench::send(peer, as_text(input.take(1 + input.below(40))));
        if (input.flag()) Bench::send(peer, "\n");
        break;
    }
  }
  for (Peer& peer : peers) bench.finish(peer);
  bench.drain();
}

}  // namespace geodesic::fuzz
