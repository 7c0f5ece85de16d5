// The daemon's status as a table for people. Formats only.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace geodesic::tools {

/// @param status  the answer to {"cmd":"status"}; what is missing in it shows as "-"
std::string status_table(const nlohmann::json& status);

}  // namespace geodesic::tools
