// Fuzz target: one line to the daemon's control socket and its answer.
#include "tools/geodesicd/requests.hpp"

#include <nlohmann/json.hpp>

#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {

void requests(Bytes bytes) {
  Input input(bytes);
  const std::uint8_t daemon = input.byte();
  const bool accepts = (daemon & 1U) != 0;
  bool exit_asked = false;
  int handed_over = 0;
  tools::RequestActions actions;
  actions.allow_zero_law = (daemon & 2U) != 0;
  actions.status = [] { return nlohmann::ordered_json{{"ok", true}, {"state", "active"}}; };
  actions.exit = [&exit_asked] { exit_asked = true; };
  actions.ending = [daemon] { return (daemon & 4U) != 0; };
  actions.hand_over = [&](const control::Request& request) {
    ++handed_over;
    expect(actions.allow_zero_law || request.kind != control::Request::Kind::kLaw ||
               request.law != control::LawKind::kZero,
           "the law that lets the arm fall needs its permission");
    return accepts;
  };
  const std::string_view line = as_text(input.rest());
  const std::string answer = tools::answer_request(line, actions);
  expect(answer.find('\n') == std::string::npos, "an answer is one line");
  const nlohmann::json parsed = nlohmann::json::parse(answer, nullptr, false);
  expect(parsed.is_object() && parsed.contains("ok") && parsed["ok"].is_boolean(),
         "an answer is one JSON object with \"ok\"");
  const bool ok = parsed["ok"].get<bool>();
  expect(ok || (parsed.contains("error") && parsed["error"].is_string() &&
                !parsed["error"].get_ref<const std::string&>().empty()),
         "a refusal says why");
  expect(handed_over <= 1 && (handed_over == 0 || !exit_asked), "one request asks one thing");
  expect(ok || !exit_asked, "what is refused is not done");
  expect(!ok || handed_over == 0 || accepts, "what could not be handed over is not called done");
}

}  // namespace geodesic::fuzz
