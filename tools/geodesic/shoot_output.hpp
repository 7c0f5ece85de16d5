// What `geodesic shoot` shows of a motion: words, JSON, a table (CSV), a picture. The motion itself
// comes from shoot_motion.hpp.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "control/mechanism/geodesic_between.hpp"
#include "tools/geodesic/shoot_motion.hpp"

namespace geodesic::tools {

/// The geodesic between two configurations beside the straight line.
struct Comparison {
  control::GeodesicBetween found;
  control::Action geodesic;
  control::Action straight;
  std::vector<Sample> line;  ///< the straight line at the motion's instants
};

struct Shot {
  std::string robot;
  std::string frame;
  ShootOptions options;
  Motion motion;
  Conservation conservation;
  std::optional<Comparison> between;
};

/// Names of the numbers of q: the joint's, with .x, .y, .z, .qx ... where it has several.
std::vector<std::string> coordinate_names(const control::Mechanism& mechanism);

nlohmann::ordered_json to_json(const control::Mechanism& mechanism, const Shot& shot);

void print(const control::Mechanism& mechanism, const Shot& shot);

/// time, q, v, energies, momentum (base floating), place of the frame; one line an instant.
std::string to_csv(const control::Mechanism& mechanism, const Motion& motion);

/// Draws the motion by Python's matplotlib into a PNG (or what the file's ending says).
/// @param answer  as to_json() made it    @throws BadInput saying what is missing.
void draw(const control::Mechanism& mechanism, const nlohmann::ordered_json& answer,
          const std::string& file);

}  // namespace geodesic::tools
