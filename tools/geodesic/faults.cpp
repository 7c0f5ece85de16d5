// `geodesic faults`: prints the policy table, which is the code that a running daemon obeys.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "control/safety/supervisor.hpp"
#include "tools/geodesic/command.hpp"

namespace geodesic::tools {
namespace {

nlohmann::ordered_json table_json() {
  nlohmann::ordered_json table = nlohmann::ordered_json::array();
  const control::SafetyOptions defaults;
  for (std::size_t i = 0; i < control::kFaults; ++i) {
    const control::FaultPolicy& line = control::policy(static_cast<control::Fault>(i));
    table.push_back({{"fault", line.name},
                     {"of", control::to_string(line.subject)},
                     {"meaning", line.meaning},
                     {"detected_by", line.detection},
                     {"within", control::to_string(line.within)},
                     {"cycles_by_default", control::cycles_to_detect(line.fault, defaults)},
                     {"looked_for_in", control::states_in_words(line.states)},
                     {"action", control::to_string(line.action)},
                     {"cleared_by", control::to_string(line.clears)}});
  }
  return table;
}

}  // namespace

void add_faults(CLI::App& app, Run& run) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("faults", "Every fault: how it is found, what is done, what clears it");
  command->add_flag("--json", *as_json, "as JSON, one object a fault");
  command->footer(footer("  geodesic faults\n  geodesic faults --json"));
  command->callback([as_json, &run] {
    run = [as_json] {
      fmt::print("{}", *as_json ? table_json().dump(2) + "\n" : control::policy_table_markdown());
      return kExitOk;
    };
  });
}

}  // namespace geodesic::tools
