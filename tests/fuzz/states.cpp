// Fuzz target: the file of states that `geodesic model --states` reads.
#include "tools/geodesic/states_file.hpp"

#include "config/urdf.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tools/geodesic/command.hpp"

namespace geodesic::fuzz {
namespace {

const control::Mechanism& planar() {
  static const control::Mechanism mechanism(
      config::load_urdf(
          std::filesystem::path(GEODESIC_SOURCE_DIR) / "config/robots/planar2r/planar2r.urdf",
          false)
          .tree,
      {0.0, 0.0, -9.81});
  return mechanism;
}

}  // namespace

void states(Bytes bytes) {
  const std::filesystem::path file = write_scratch("states.json", as_text(bytes));
  try {
    tools::StatesFile read = tools::read_states(file.string());
    tools::fit_states(read, planar(), file.string());
    for (const tools::EvaluationState& state : read.states) {
      for (const Eigen::VectorXd* each : {&state.q, &state.v, &state.a}) {
        expect(each->size() == planar().dof() && each->allFinite(), "finite, one for each joint");
      }
    }
    expect(!read.gravity || read.gravity->allFinite(), "gravity is finite");
  } catch (const tools::BadInput& problem) {
    const std::string text = problem.what();
    expect(text.rfind(file.string() + ": ", 0) == 0, "an error begins with its file");
    expect(text.size() > file.string().size() + 4, "and says what is wrong");
  }
}

}  // namespace geodesic::fuzz
