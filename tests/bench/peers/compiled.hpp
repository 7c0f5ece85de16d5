// Where the bench finds models compiled ahead as a peer; unlike the others it lives in the bench.
#pragma once

#include "tests/bench/peers/peer.hpp"

namespace geodesic::bench {

const Peer& compiled_peer();

}  // namespace geodesic::bench
