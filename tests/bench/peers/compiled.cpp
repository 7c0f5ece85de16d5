// A model that `geodesic compile` built for one robot, through the door of the peers.
#include "tools/compile/abi.hpp"

#include <dlfcn.h>

#include "tests/bench/peers/compiled.hpp"

namespace geodesic::bench {
namespace {

struct Model {
  void* library;
  const geodesic_compiled* compiled;
};

void* make(const PeerRobot* robot, const char** why) {
  if (robot->compiled == nullptr) {
    *why = "not compiled";
    return nullptr;
  }
  void* library = ::dlopen(robot->compiled, RTLD_NOW | RTLD_LOCAL);
  using Entry = const geodesic_compiled* (*)();
  auto* entry = library != nullptr
                    ? reinterpret_cast<Entry>(::dlsym(library, tools::compile::kCompiledSymbol))
                    : nullptr;
  if (entry == nullptr || entry()->abi != tools::compile::kCompiledAbi ||
      entry()->nv != robot->dof || entry()->nq != robot->nq) {
    *why = "the compiled file is no model of this robot";
    return nullptr;
  }
  return new Model{library, entry()};
}

const geodesic_compiled& of(void* model) {
  return *static_cast<Model*>(model)->compiled;
}

void destroy(void* model) {
  ::dlclose(static_cast<Model*>(model)->library);
  delete static_cast<Model*>(model);
}

void bias(void* model, const double* q, const double* v, const double* /*x*/, double* out) {
  of(model).bias(q, v, out);
}

void gravity(void* model, const double* q, const double* /*v*/, const double* /*x*/, double* out) {
  of(model).gravity(q, out);
}

void inverse_dynamics(void* model, const double* q, const double* v, const double* a, double* out) {
  of(model).inverse_dynamics(q, v, a, out);
}

void mass_matrix(void* model, const double* q, const double* /*v*/, const double* /*x*/,
                 double* out) {
  of(model).metric(q, out);
}

}  // namespace

const Peer& compiled_peer() {
  static constexpr Peer kPeer{
      "compiled", GEODESIC_VERSION,
      1e-9,       make,
      destroy,    {bias, gravity, inverse_dynamics, mass_matrix, nullptr, nullptr, nullptr}};
  return kPeer;
}

}  // namespace geodesic::bench
