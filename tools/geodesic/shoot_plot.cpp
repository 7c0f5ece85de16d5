// The picture of `geodesic shoot`: its figures for matplotlib.
#include <nlohmann/json.hpp>
#include <string>

#include "tools/geodesic/picture.hpp"
#include "tools/geodesic/shoot_output.hpp"
#include "tools/geodesic/shoot_plot_script.hpp"  // made of shoot_plot.py

namespace geodesic::tools {

void draw(const control::Mechanism& mechanism, const nlohmann::ordered_json& answer,
          const std::string& file) {
  nlohmann::ordered_json figures = answer;
  nlohmann::ordered_json joints = nlohmann::ordered_json::array();
  for (const control::Factor& factor : mechanism.factors()) {
    if (factor.nq != 1) continue;
    joints.push_back({{"name", factor.name},
                      {"q", factor.q},
                      {"turns", factor.kind != control::JointKind::kPrismatic}});
  }
  figures["joints"] = joints;
  draw_picture(kShootPlotScript, figures, file, "--csv FILE writes the figures without");
}

}  // namespace geodesic::tools
