// `geodesic scan`: which drives answer on these buses. What is asked of them is their families';
// what is proposed is in scan_proposal.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/findings.hpp"
#include "tools/geodesic/bench_bus.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/scan_proposal.hpp"
#include "tools/sim/stop_signals.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

struct ScanArguments {
  std::vector<std::string> buses;
  std::vector<std::string> families;
  std::string folder;
  bool classic = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic scan                             every CAN interface that is up\n"
    "  geodesic scan can0 can1 --write mybot     and mybot/robot.toml, robot.urdf to begin with\n"
    "  geodesic scan can0 --family damiao --classic\n"
    "  geodesic scan unix:/tmp/arm --json";

/// What one dialogue of one bus came to.
struct Pass {
  std::string interface;
  std::string family;
  bool fd = false;
  DialogueEnd end = DialogueEnd::kOver;
};

struct Result {
  std::vector<Sighting> sightings;
  std::vector<Pass> passes;
  bool stopped = false;
  bool complete = true;
};

/// On a terminal a line that is written over, else a line each.
class Progress {
 public:
  Progress() : terminal_(::isatty(STDERR_FILENO) == 1) {}
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin(const Pass& pass, std::size_t number, std::size_t of) {
    text_ = fmt::format("scanning {} for {}{} ({} of {})", pass.interface, pass.family,
                        pass.fd ? ", CAN FD" : "", number, of);
    if (!terminal_) fmt::print(stderr, "{}\n", text_);
  }
  void show(std::size_t found) {
    if (!terminal_) return;
    fmt::print(stderr, "\r\033[K{}: {} found", text_, found);
    std::fflush(stderr);
  }
  void clear() {
    if (terminal_) fmt::print(stderr, "\r\033[K");
  }

 private:
  bool terminal_;
  std::string text_;
};

std::vector<const drivers::Family*> chosen_families(const std::vector<std::string>& names) {
  std::vector<const drivers::Family*> chosen;
  std::vector<std::string> known;
  for (const drivers::Family& family : drivers::families()) {
    known.emplace_back(family.name);
    if (names.empty() && family.make_scanner != nullptr) chosen.push_back(&family);
  }
  for (const std::string& name : names) {
    const drivers::Family* family = drivers::find_family(name);
    if (family == nullptr || family->make_scanner == nullptr) {
      throw BadInput(fmt::format(
          "--family: there is no family {} that can be scanned for{}; "
          "families: {}",
          config::quote(name), config::did_you_mean(name, known), config::list_names(known)));
    }
    chosen.push_back(family);
  }
  return chosen;
}

bool seen(const Result& result, const Sighting& one) {
  return std::any_of(result.sightings.begin(), result.sightings.end(), [&](const Sighting& other) {
    return other.interface == one.interface && other.family == one.family &&
           other.drive.id == one.drive.id && other.drive.reply_id == one.drive.reply_id;
  });
}

void take(const drivers::Scanner& scanner, const Pass& pass, Result& result) {
  for (drivers::FoundDrive& drive : scanner.found()) {
    Sighting sighting{pass.interface, pass.family, pass.fd, std::move(drive)};
    // One that answers both formats is listed once, by the format that everybody understands.
    if (!seen(result, sighting)) result.sightings.push_back(std::move(sighting));
  }
}

/// All families on one bus, one after the other: first classic frames, which every node takes, then
/// CAN FD, which a classic one would destroy by error frames; only if the interface is set up for
/// it.
void scan_bus(const std::string& interface, const ScanArguments& arguments,
              const StopSignals& signals, Progress& progress, Result& result) {
  const std::vector<const drivers::Family*> families = chosen_families(arguments.families);
  const bool fd = !arguments.classic && carries_fd(device_of(interface));
  BenchBus bus(device_of(interface), fd);
  const std::size_t of = families.size() * (fd ? 2 : 1);
  std::size_t number = 0;
  for (const bool with_fd : {false, true}) {
    if (with_fd && !fd) break;
    for (const drivers::Family* family : families) {
      Pass pass{interface, std::string(family->name), with_fd};
      ++number;
      const std::unique_ptr<drivers::Scanner> scanner = family->make_scanner(with_fd);
      if (!scanner) continue;
      progress.begin(pass, number, of);
      pass.end = bus.hold(*scanner, signals.requested(), signals.waiting_mask(),
                          [&] { progress.show(scanner->found().size()); });
      take(*scanner, pass, result);
      result.passes.push_back(pass);
      result.complete = result.complete && pass.end == DialogueEnd::kOver;
      result.stopped = pass.end == DialogueEnd::kStopped;
      if (pass.end == DialogueEnd::kStopped || pass.end == DialogueEnd::kDeaf) return;
    }
  }
}

ordered_json to_json(const Result& result, const Proposal& proposal,
                     const std::vector<std::string>& errors) {
  ordered_json drives = ordered_json::array();
  for (const Sighting& sighting : result.sightings) {
    ordered_json options = ordered_json::object();
    for (const auto& [key, value] : sighting.drive.options) options[key] = value;
    drives.push_back({{"bus", sighting.interface},
                      {"family", sighting.family},
                      {"fd", sighting.fd},
                      {"id", sighting.drive.id},
                      {"reply_id", sighting.drive.reply_id},
                      {"model", sighting.drive.model},
                      {"firmware", sighting.drive.firmware},
                      {"options", std::move(options)},
                      {"remarks", sighting.drive.remarks}});
  }
  return {{"complete", result.complete && errors.empty()},
          {"drives", std::move(drives)},
          {"errors", errors},
          {"gaps", proposal.gaps},
          {"toml", result.sightings.empty() ? "" : proposal.toml},
          {"urdf", result.sightings.empty() ? "" : proposal.urdf}};
}

void print_table(const Result& result) {
  fmt::print("{:<14} {:<13}{:>10}{:>10}  {:<14}{}\n", "bus", "family", "id", "answers", "firmware",
             "model");
  for (const Sighting& sighting : result.sightings) {
    const drivers::FoundDrive& drive = sighting.drive;
    fmt::print("{:<14} {:<13}{:>10}{:>10}  {:<14}{}{}\n", sighting.interface, sighting.family,
               fmt::format("0x{:02X}", drive.id),
               drive.reply_id == 0 ? "-" : fmt::format("0x{:02X}", drive.reply_id),
               drive.firmware.empty() ? "-" : drive.firmware,
               drive.model.empty() ? "-" : drive.model, sighting.fd ? " (CAN FD)" : "");
    for (const std::string& remark : drive.remarks) fmt::print("    note: {}\n", remark);
  }
}

void write_proposal(const std::string& folder, const Proposal& proposal) {
  const std::filesystem::path place(folder);
  std::error_code problem;
  std::filesystem::create_directories(place, problem);
  for (const auto& [name, text] :
       {std::pair{"robot.urdf", &proposal.urdf}, std::pair{"robot.toml", &proposal.toml}}) {
    const std::filesystem::path file = place / name;
    if (std::filesystem::exists(file, problem)) {
      throw BadInput(
          fmt::format("{} exists already; nothing is written over it: choose another "
                      "folder, or move it away",
                      file.string()));
    }
    write_file(file.string(), *text);
  }
}

int run_scan(ScanArguments arguments) {
  chosen_families(arguments.families);  // wrong names are said before a bus is touched
  if (arguments.buses.empty()) arguments.buses = can_interfaces();
  if (arguments.buses.empty()) {
    throw BadInput(
        "no CAN interface is up, so there is nothing to scan; bring one up, for example: sudo ip "
        "link set can0 up type can bitrate 1000000   (or name a socket bus: unix:PATH)");
  }
  const StopSignals signals;
  Result result;
  std::vector<std::string> errors;
  {
    Progress progress;
    for (const std::string& interface : arguments.buses) {
      if (result.stopped) break;
      try {
        scan_bus(interface, arguments, signals, progress, result);
      } catch (const drivers::BusError& error) {
        errors.emplace_back(error.what());
      }
    }
  }
  for (const Pass& pass : result.passes) {
    if (pass.end == DialogueEnd::kDeaf) errors.push_back(deaf_text(pass.interface));
    if (pass.end == DialogueEnd::kEndless) {
      errors.push_back(fmt::format("{}: scanning for {} did not end", pass.interface, pass.family));
    }
  }
  if (result.stopped) errors.emplace_back("stopped before the end: there may be more drives");
  compare(result.sightings);
  const Proposal proposal = propose(result.sightings);
  for (const std::string& error : errors) fmt::print(stderr, "geodesic: error: {}\n", error);
  if (arguments.json) {
    fmt::print("{}\n", to_json(result, proposal, errors).dump(2));
  } else if (result.sightings.empty()) {
    fmt::print("no drive has answered\n");
    if (errors.empty()) {
      fmt::print(
          "check supply and wiring, the bit rate, and that interface and drives agree on "
          "classic CAN or CAN FD; `geodesic doctor` looks at the interfaces\n");
    }
  } else {
    print_table(result);
    if (arguments.folder.empty()) fmt::print("\n{}", proposal.toml);
    for (const std::string& gap : proposal.gaps) fmt::print(stderr, "to fill in: {}\n", gap);
  }
  if (!arguments.folder.empty() && !result.sightings.empty()) {
    write_proposal(arguments.folder, proposal);
    if (!arguments.json)
      fmt::print("\nwritten: {0}/robot.toml, {0}/robot.urdf\n", arguments.folder);
  }
  return errors.empty() && !result.sightings.empty() ? kExitOk : kExitRefused;
}

}  // namespace

void add_scan(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ScanArguments>();
  CLI::App* command = app.add_subcommand(
      "scan", "Which drives answer on these buses, and a robot file to begin with");
  command->add_option("BUS", arguments->buses,
                      "can0, vcan0, unix:PATH ... (default: every CAN interface that is up)");
  command->add_option("--family", arguments->families, "look for this family only; repeatable")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_flag("--classic", arguments->classic,
                    "no CAN FD frames, though the interface is set up for them");
  command->add_option("--write", arguments->folder,
                      "write the proposed robot.toml and a stand-in robot.urdf into this folder");
  command->add_flag("--json", arguments->json, "drives, proposal and errors as one JSON object");
  command->footer(
      "\nNo drive is moved, enabled or written to: drives are asked for their identity, one frame "
      "at\na time with pauses. Classic CAN first; CAN FD only where the interface is set up for "
      "it.\nRefused while a daemon of this host commands the bus. Drives that another host "
      "commands would\nhear foreign requests: stop that one first." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_scan(*arguments); }; });
}

}  // namespace geodesic::tools
