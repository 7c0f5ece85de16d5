// `geodesic bus`: a socket bus alone, for programs that come and go.
#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

#include "drivers/bus/socket_bus_hub.hpp"
#include "drivers/bus/unix_address.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/sim/stop_signals.hpp"

namespace geodesic::tools {
namespace {

struct BusArguments {
  std::string path;
  std::string paced;
  bool json = false;
};

std::int64_t bit_rate(std::string_view text, std::string_view whole) {
  std::int64_t rate = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rate);
  if (error != std::errc() || end != text.data() + text.size() || rate < 1000 ||
      rate > 20'000'000) {
    throw BadInput(
        fmt::format("--paced {}: '{}' is no bit rate; expected BITRATE or BITRATE/DATA "
                    "in bit/s, from 1000 to 20000000, for example 1000000/5000000",
                    whole, text));
  }
  return rate;
}

int run_bus(const BusArguments& arguments) {
  if (!drivers::is_socket_bus(arguments.path)) {
    throw BadInput("'" + arguments.path + "' is no socket bus; expected unix:PATH");
  }
  drivers::SocketBusHubOptions options;
  options.path = arguments.path;
  if (!arguments.paced.empty()) {
    options.paced = true;
    const std::string_view text = arguments.paced;
    const std::size_t slash = text.find('/');
    options.bit_rate = bit_rate(text.substr(0, slash), text);
    options.data_bit_rate =
        slash == std::string_view::npos ? options.bit_rate : bit_rate(text.substr(slash + 1), text);
  }
  const StopSignals signals;
  const drivers::SocketBusHub hub(options);
  fmt::print(arguments.json ? stderr : stdout, "geodesic bus: serving {}{}\n", arguments.path,
             options.paced ? fmt::format(", {}/{} bit/s", options.bit_rate, options.data_bit_rate)
                           : std::string());
  std::fflush(nullptr);
  while (!signals.requested().load()) {
    const timespec nap{1, 0};
    ppoll(nullptr, 0, &nap, &signals.waiting_mask());
  }
  const drivers::SocketBusHubCounters counters = hub.counters();
  if (arguments.json) {
    const nlohmann::ordered_json result{{"bus", arguments.path},
                                        {"carried", counters.carried},
                                        {"dropped", counters.dropped},
                                        {"clients", counters.clients}};
    fmt::print("{}\n", result.dump());
  } else {
    fmt::print("geodesic bus: {} frames carried, {} copies dropped\n", counters.carried,
               counters.dropped);
  }
  return kExitOk;
}

}  // namespace

void add_bus(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<BusArguments>();
  CLI::App* command = app.add_subcommand(
      "bus", "A socket bus: CAN semantics between programs of one host, without kernel CAN");
  command->add_option("BUS", arguments->path, "unix:PATH")->required();
  command->add_option("--paced", arguments->paced,
                      "BITRATE[/DATA]: frames take the time bits take [bit/s]");
  command->add_flag("--json", arguments->json, "print the counters as JSON at the end");
  command->footer(
      "\nServes until SIGINT or SIGTERM. `geodesic sim` serves its own bus where nobody "
      "does." +
      footer("  geodesic bus unix:/tmp/arm\n"
             "  geodesic bus unix:/tmp/arm --paced 1000000/5000000"));
  command->callback([arguments, &run] { run = [arguments] { return run_bus(*arguments); }; });
}

}  // namespace geodesic::tools
