// The part of an emitted file that does not depend on the robot.
#include "tools/compile/emit.hpp"

namespace geodesic::tools::compile {
namespace {

constexpr const char* kPreamble = R"cpp(
#include <cmath>
#include <cstdint>
#include <limits>
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#include <immintrin.h>
#define GEODESIC_MASKS 1
#endif

  extern "C" struct geodesic_compiled {
    std::uint32_t abi;
    std::uint32_t isa_level;
    const char* robot;
    const char* fingerprint;
    std::int32_t nq;
    std::int32_t nv;
    void (*bias)(const double* q, const double* v, double* out);
    void (*gravity)(const double* q, double* out);
    void (*metric)(const double* q, double* out);
    void (*inverse_dynamics)(const double* q, const double* v, const double* a, double* out);
  };

  namespace {

  // Joint angles are turned into sines and cosines all at once, one lane each.
  typedef double Lanes __attribute__((vector_size(64)));
  typedef long long Bits __attribute__((vector_size(64)));

  constexpr double kFar = 1e6;

  // The first n of eight numbers; the others are zero.
  template <int n>
  inline Lanes load(const double* from) {
#ifdef GEODESIC_MASKS
    return _mm512_maskz_loadu_pd((1U << n) - 1U, from);
#else
    Lanes lanes = {};
    for (int i = 0; i < n; ++i) lanes[i] = from[i];
    return lanes;
#endif
  }

  template <int lane>
  inline void put(Lanes& lanes, double number) {
#ifdef GEODESIC_MASKS
    lanes = _mm512_mask_broadcastsd_pd(lanes, 1U << lane, _mm_set_sd(number));
#else
    lanes[lane] = number;
#endif
  }

  // Whether one of the angles is beyond kFar or no number.
  inline bool is_far(Lanes angle) {
#ifdef GEODESIC_MASKS
    return _mm512_cmp_pd_mask(_mm512_abs_pd(angle), _mm512_set1_pd(kFar), _CMP_NLE_UQ) != 0;
#else
    bool far = false;
    for (int i = 0; i < 8; ++i) far |= !(__builtin_fabs(angle[i]) <= kFar);
    return far;
#endif
  }

  // Far angles lose whole turns first: std::remainder is exact.
  __attribute__((cold, noinline)) void bring_near(Lanes* angle) {
    for (int i = 0; i < 8; ++i) {
      (*angle)[i] = std::remainder((*angle)[i], 6.283185307179586);
    }
  }

  // Whether one of n numbers is infinite or no number.
  template <int n>
  inline bool is_odd(const double* from) {
#ifdef GEODESIC_MASKS
    constexpr int kNanOrInfinite = 0x99;
    unsigned found = 0;
    for (int i = 0; i < n; i += 8) {
      const unsigned mask = n - i >= 8 ? 0xffU : (1U << (n - i)) - 1U;
      found |= _mm512_fpclass_pd_mask(_mm512_maskz_loadu_pd(static_cast<__mmask8>(mask), from + i),
                                      kNanOrInfinite);
    }
    return found != 0;
#else
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += from[i] * 0.0;
    return !(sum == 0.0);
#endif
  }

  // |angle| <= kFar. Reduction by pi/2 in parts (Cody, Waite 1980); polynomials of degree 5 in the
  // square, interpolated at Chebyshev's nodes over [0, (pi/4)^2]: errors 1.4e-17 and 8e-19.
  inline void sine_cosine(Lanes x, Lanes& sine, Lanes& cosine) {
    const Lanes shifted = x * 0x1.45f306dc9c883p-1 + 0x1.8p+52;
    const Lanes turn = shifted - 0x1.8p+52;
#ifdef __FMA__
    // Fused: the first difference is exact but for one rounding of itself.
    const Lanes r = (x - turn * 0x1.921fb54442d18p+0) - turn * 0x1.1a62633145c07p-54;
#else
    const Lanes r =
        ((x - turn * 0x1.921fb544p+0) - turn * 0x1.0b4611a6p-34) - turn * 0x1.3198a2e037073p-69;
#endif
    const Lanes z = r * r;
    const Lanes w = z * z;
    const Lanes ww = w * w;
    const Lanes s = (-0x1.5555555555555p-3 + z * 0x1.1111111110bb2p-7) +
                    w * (-0x1.a01a019e83816p-13 + z * 0x1.71de379654304p-19) +
                    ww * (-0x1.ae600aca92c64p-26 + z * 0x1.5e0b05bff20f2p-33);
    const Lanes c = (0x1.5555555555555p-5 + z * -0x1.6c16c16c16967p-10) +
                    w * (0x1.a01a019f4e9b4p-16 + z * -0x1.27e4fa17bf139p-22) +
                    ww * (0x1.1eeb68cd22f56p-29 + z * -0x1.907d8f29fe831p-37);
    const Lanes sine_r = r + (r * z) * s;
    const Lanes cosine_r = 1.0 - (0.5 * z - w * c);
    // Quarter turn k: sine and cosine change places where k is odd, signs follow its second bit.
    const Bits k = reinterpret_cast<const Bits&>(shifted);
    const Bits odd = -(k & 1);
    const Bits s_bits = reinterpret_cast<const Bits&>(sine_r);
    const Bits c_bits = reinterpret_cast<const Bits&>(cosine_r);
    const Bits sine_bits = ((s_bits & ~odd) | (c_bits & odd)) ^ ((k & 2) << 62);
    const Bits cosine_bits = ((c_bits & ~odd) | (s_bits & odd)) ^ (((k + 1) & 2) << 62);
    sine = reinterpret_cast<const Lanes&>(sine_bits);
    cosine = reinterpret_cast<const Lanes&>(cosine_bits);
  }

  // What is computed of numbers that are none is none: makes results of the arms concerned NaN,
  // also those that do not depend on the number.
  __attribute__((cold, noinline)) void spoil(const double* q, const double* v, const double* a,
                                             double* out, bool matrix) {
    bool odd[kArms] = {};
    for (int i = 0; i < kNq; ++i) odd[kArmOfQ[i]] |= !(q[i] - q[i] == 0.0);
    for (int i = 0; i < kNv; ++i) {
      odd[kArmOfV[i]] |= v != nullptr && !(v[i] - v[i] == 0.0);
      odd[kArmOfV[i]] |= a != nullptr && !(a[i] - a[i] == 0.0);
    }
    for (int i = 0; i < kNv; ++i) {
      for (int j = 0; j < (matrix ? kNv : 1); ++j) {
        if (odd[kArmOfV[i]] && (!matrix || kArmOfV[i] == kArmOfV[j])) {
          out[matrix ? i * kNv + j : i] = std::numeric_limits<double>::quiet_NaN();
        }
      }
    }
  }

  }  // namespace
)cpp";

}  // namespace

std::string emit_preamble() {
  return kPreamble;
}

}  // namespace geodesic::tools::compile
