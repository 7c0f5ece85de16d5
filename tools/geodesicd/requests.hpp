// What operators may ask of a running daemon, one line of JSON each, and the answers. Knows neither
// the socket they come by nor the thread that follows them.
//
//   {"cmd":"status"}              -> {"ok":true, ...} as status_json() says
//   {"cmd":"law","law":"float"}   -> {"ok":true,"law":"float"}: asked of the real-time thread
//   {"cmd":"stop"}                -> {"ok":true,"exit":false}: controlled stop, the daemon stays
//   {"cmd":"stop","exit":true}    -> {"ok":true,"exit":true}: controlled stop, then it ends
//   {"cmd":"tune","set":{"joint.elbow.hold_stiffness":30,"payload":"box"}}
//       -> {"ok":true,"changes":[{"option","from","to","unit","text"}],"changed":2,"messages":[]}:
//          they count from the next cycle on; all of them, or with "ok":false none
//   {"cmd":"tune","undo":true}    -> as above: the last "set" taken back
//   {"cmd":"tune","list":true}    -> {"ok":true,"options":[{"option","value","unit","range"}]}
//   {"cmd":"tune","tuned":true}   -> {"ok":true,"file":"...","tuned":[{"option","value"}]}: what
//                                    stands in front of the file's values
//   anything else                 -> {"ok":false,"error":"..."}
// A request may have 4096 bytes. Status has "tuning": {"payload", "tuned", "undoable", "last"}, the
// last being what became of the last save, SIGHUP, "set" or "undo".
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "control/controller.hpp"

namespace geodesic::tools {

/// What requests are carried out with.
struct RequestActions {
  std::function<nlohmann::ordered_json()> status;
  std::function<nlohmann::ordered_json(const nlohmann::json&)> tune;
  std::function<bool(const control::Request&)> hand_over;  ///< false: not now
  std::function<void()> exit;
  std::function<bool()> ending;
  bool allow_zero_law = false;
};

/// @param line  one request  @return one answer; neither holds a newline. Never throws for what a
/// line says.
std::string answer_request(std::string_view line, const RequestActions& actions);

}  // namespace geodesic::tools
