// Pictures: hands figures to matplotlib in a Python of its own. What is drawn stands in the scripts
// that the program carries with it (*_plot.py).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace geodesic::tools {

/// Draws by a script that takes two arguments: a JSON file of the figures, the picture's file (PNG,
/// or what its ending says). Not real-time.
/// @param otherwise  what to do without matplotlib, a sentence    @throws BadInput saying what is
/// missing.
void draw_picture(const char* script, const nlohmann::ordered_json& figures,
                  const std::string& file, const std::string& otherwise);

}  // namespace geodesic::tools
