// What the run amounts to so far, as JSON: the answer to `status` and the summary at the end
// (design: `--summary FILE`). Reads; writes nothing.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "rt/cyclic_thread.hpp"
#include "tools/geodesicd/bus_keeper.hpp"
#include "tools/geodesicd/event_text.hpp"
#include "tools/geodesicd/phases.hpp"
#include "tools/geodesicd/telemetry.hpp"

namespace geodesic::tools {

/// The run's faults and warnings in order; the first kMost of them, and how many in all.
struct FaultList {
  static constexpr std::size_t kMost = 256;
  nlohmann::ordered_json entries = nlohmann::ordered_json::array();
  std::uint64_t count = 0;

  /// Takes a fault; changes of state are not its business.
  void add(const Event& event, const EventText& text);
};

/// Whatever a report is made of. All of it outlives the report's making.
struct RunView {
  const Vocabulary& words;
  const rt::LoopStatistics& loop;
  const Phases& phases;
  const Record& last;  ///< the newest cycle known
  const Counters& counters;
  const FaultList& faults;
  std::string not_realtime_reason;
  std::uint64_t records_dropped = 0;
  std::uint64_t events_dropped = 0;
  bool simulated_time = false;
  std::string not_sealed_reason;
  BusKeeper::Health bus_health{};
};

/// One answer to {"cmd":"status"}, "ok" among it.
nlohmann::ordered_json status_json(const RunView& run);

/// The summary of a run. `forced`: torque was taken off without a controlled stop.
nlohmann::ordered_json summary_json(const RunView& run, bool forced);

/// The summary of a start that was refused: the same keys, nothing counted, and why.
nlohmann::ordered_json refused_summary_json(const std::string& robot, std::int64_t period_ns,
                                            const std::string& error);

/// {min, p50, p99, p999, max} [ns].
nlohmann::ordered_json to_json(const rt::Histogram& histogram);

}  // namespace geodesic::tools
