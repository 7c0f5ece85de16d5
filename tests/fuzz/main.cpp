// The fuzzer's entry for one target, named by GEODESIC_FUZZ_TARGET at compile time.
#include "tests/fuzz/fuzz.hpp"

#ifndef GEODESIC_FUZZ_TARGET  // editors and linters look at this file without the build's words
#define GEODESIC_FUZZ_TARGET frames
#endif

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  geodesic::fuzz::GEODESIC_FUZZ_TARGET({data, size});
  return 0;
}
