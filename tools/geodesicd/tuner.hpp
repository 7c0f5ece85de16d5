// Decides what a running daemon takes over: a file that was saved, values that an operator sets,
// and the way back. All or nothing: one refused change and nothing is taken, each refusal by name.
// Hands a whole setup on; knows neither threads nor sockets.
//
// File and tuned values: a tuned value stands in front of the file's until it is undone, or until a
// later save changes that very key: then the file has said something newer and wins. Keys that a
// save leaves alone stay tuned.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/difference.hpp"
#include "config/robot.hpp"
#include "control/setup.hpp"
#include "tools/compile/agreement.hpp"
#include "tools/geodesicd/options.hpp"
#include "tools/geodesicd/telemetry.hpp"

namespace geodesic::tools {

/// What became of one attempt.
struct TuneOutcome {
  bool ok = false;
  std::vector<config::Change> changes;  ///< what counts now and did not before; none if not ok
  std::vector<std::string> problems;    ///< why nothing was taken
  std::vector<std::string> notes;       ///< what else there is to say
};

class Tuner {
 public:
  enum class Verdict : std::uint8_t {
    kTaken,
    kRefused,  ///< by the real-time thread: the arm is beyond the new limits
    kBusy,     ///< the last one is still on its way: not handed over
    kUnknown,  ///< handed over; whether it counts is not known yet, taken() or refused() will say
  };
  using HandOver = std::function<Verdict(std::unique_ptr<const control::Setup>)>;

  /// @param start  what the daemon started with, before the command line was applied
  /// @param compiled  the model's compiled functions: they are taken for their own mechanism only,
  ///   for any other that is tuned the algorithms are; null: there are none
  Tuner(CommandLine line, config::LoadResult start, HandOver hand_over,
        const compile::VerifiedModel* compiled = nullptr);

  /// The files have been saved, or somebody wants them read. `now`: the newest cycle.
  TuneOutcome reload(const Record& now);
  /// Sets options. Keys as people write them ("payload"), values as they type them.
  TuneOutcome set(const std::vector<config::Override>& asked, const Record& now);
  /// Takes back what the last successful set() did, to the bit.
  TuneOutcome undo(const Record& now);

  /// The real-time thread's late word on what was handed over as kUnknown.
  void taken() { before_.reset(); }
  void refused();

  /// As it counts now.
  const config::Robot& robot() const noexcept { return now_.loaded.robot; }
  /// Values that stand in front of the file's, in the order in which they were set.
  const std::vector<config::Override>& tuned() const noexcept { return now_.tuned; }
  std::size_t undoable() const noexcept { return now_.undo.size(); }

 private:
  struct Step {
    std::string path;
    std::string before;  ///< empty: it was not tuned
  };
  struct State {
    config::LoadResult file;    ///< the last file that was taken, nothing tuned
    config::LoadResult loaded;  ///< with what is tuned
    std::vector<config::Override> tuned;
    std::vector<std::vector<Step>> undo;
  };

  config::LoadResult load(const std::optional<config::RobotText>& text,
                          const std::vector<config::Override>& tuned) const;
  TuneOutcome take(State next, const Record& now);
  std::unique_ptr<const control::Setup> make_setup(const config::Robot& robot,
                                                   const control::Setup& before,
                                                   std::vector<std::string>& notes) const;

  CommandLine line_;
  HandOver hand_over_;
  const compile::VerifiedModel* compiled_;
  State now_;
  std::unique_ptr<State> before_;  ///< while it is not known whether now_ counts
};

/// Why the arm as it is now may not have the new limits, with the figures: each a sentence; none:
/// it may. Looks at limits that changed only, and at nothing of a joint that was not measured yet.
std::vector<std::string> excluded_now(const config::Robot& from, const config::Robot& to,
                                      const Record& now);

}  // namespace geodesic::tools
