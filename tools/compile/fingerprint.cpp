// FNV-1a in 128 bits (Fowler, Noll, Vo; RFC 9923); see fingerprint.hpp.
#include "tools/compile/fingerprint.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <string_view>

namespace geodesic::tools::compile {
namespace {

// ISO C++ has no such type; every compiler this is built with has.
__extension__ using Wide = unsigned __int128;

class Digest {
 public:
  void add(const char* bytes, std::size_t size) {
    constexpr Wide kPrime = (Wide{1} << 88) + 0x13b;
    for (std::size_t i = 0; i < size; ++i) {
      state_ = (state_ ^ static_cast<unsigned char>(bytes[i])) * kPrime;
    }
  }
  void add(std::uint64_t number) {
    for (int shift = 0; shift < 64; shift += 8) {
      const char byte = static_cast<char>(number >> shift);
      add(&byte, 1);
    }
  }
  void add(int number) { add(static_cast<std::uint64_t>(number)); }
  void add(double number) {
    add(std::bit_cast<std::uint64_t>(number + 0.0));  // -0 is 0
  }
  void add(std::string_view text) {
    add(static_cast<std::uint64_t>(text.size()));
    add(text.data(), text.size());
  }
  template <class Matrix>
  void add_all(const Matrix& matrix) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      for (Eigen::Index i = 0; i < matrix.rows(); ++i) add(matrix(i, j));
    }
  }
  std::string text() const {
    return fmt::format("{:016x}{:016x}", static_cast<std::uint64_t>(state_ >> 64),
                       static_cast<std::uint64_t>(state_));
  }

 private:
  Wide state_ = (Wide{0x6c62272e07bb0142ULL} << 64) + 0x62b821756295c58dULL;
};

}  // namespace

std::string fingerprint(const control::Mechanism& mechanism) {
  Digest digest;
  digest.add(std::string_view("geodesic mechanism 1"));
  digest.add(mechanism.nq());
  digest.add(mechanism.dof());
  digest.add(static_cast<int>(mechanism.floating()));
  for (const std::string& name : mechanism.joint_names()) digest.add(std::string_view(name));
  digest.add_all(mechanism.gravity());
  digest.add_all(mechanism.rotor_inertia());
  for (const control::Body& body : mechanism.bodies()) {
    digest.add(body.parent);
    digest.add(static_cast<int>(body.motion));
    digest.add(body.dof);
    digest.add(body.coordinate);
    digest.add(body.ratio);
    digest.add(body.offset);
    digest.add_all(body.parent_from_joint.rotation);
    digest.add_all(body.parent_from_joint.translation);
    digest.add(body.inertia.mass);
    digest.add_all(body.inertia.first_moment);
    // One triangle: of the other nothing is read.
    for (Eigen::Index j = 0; j < 3; ++j) {
      for (Eigen::Index i = 0; i <= j; ++i) digest.add(body.inertia.rotational(i, j));
    }
  }
  return digest.text();
}

std::string digest(const char* bytes, std::size_t size) {
  Digest digest;
  digest.add(bytes, size);
  return digest.text();
}

}  // namespace geodesic::tools::compile
