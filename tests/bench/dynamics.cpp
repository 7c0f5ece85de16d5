// Loads the peers, compares, and times them in turns.
#include "tests/bench/dynamics.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <random>
#include <stdexcept>

#include "rt/clock.hpp"
#include "tests/bench/peers/compiled.hpp"
#include "tests/bench/robots.hpp"

namespace geodesic::bench {
namespace {

constexpr std::array<const char*, kPeerFunctions> kNames{
    "bias",        "gravity",          "inverse dynamics",
    "mass matrix", "forward dynamics", "Coriolis matrix",
    "inverse of M"};
constexpr std::size_t kStates = 64;  // few enough to stay in the cache with any library

/// A library with one robot.
class Contender {
 public:
  Contender(std::string name, const Peer& peer, const PeerRobot& robot)
      : name_(std::move(name)), peer_(&peer), model_(peer.make(&robot, &why_)) {}
  ~Contender() {
    if (model_ != nullptr) {
      peer_->destroy(model_);
    }
  }
  Contender(const Contender&) = delete;
  Contender& operator=(const Contender&) = delete;

  const std::string& name() const { return name_; }
  double agreement() const { return peer_->agreement; }
  /// Null, or why this library cannot have the robot.
  const char* why_not() const { return model_ != nullptr ? nullptr : why_; }
  bool has(PeerFunction f) const { return model_ != nullptr && peer_->call[f] != nullptr; }
  void call(PeerFunction f, const double* q, const double* v, const double* x, double* out) const {
    peer_->call[f](model_, q, v, x, out);
  }

 private:
  std::string name_;
  const Peer* peer_;
  const char* why_ = "it did not say why";
  void* model_;
};

using Contenders = std::vector<std::unique_ptr<Contender>>;

/// Everything of a robot that all contenders share.
struct Course {
  std::string name;
  int nq = 0;
  int dof = 0;
  Contenders contenders;  ///< ours first
  std::vector<double> q, v, x;
  std::vector<double> out;

  void run(const Contender& who, PeerFunction f, std::size_t state) {
    const std::size_t at = state * static_cast<std::size_t>(dof);
    who.call(f, &q[state * static_cast<std::size_t>(nq)], &v[at], &x[at], out.data());
  }
};

const Peer& load(const std::string& folder, const std::string& library) {
  const std::string file = (std::filesystem::path(folder) / library).string();
  void* handle = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  auto* entry =
      handle != nullptr ? reinterpret_cast<PeerEntry>(::dlsym(handle, kPeerEntry)) : nullptr;
  if (entry == nullptr) {
    throw std::runtime_error(
        fmt::format("{}: {}; build it first: `ninja geodesic_bench`", file, ::dlerror()));
  }
  return *entry();
}

Course set_up(const std::string& file, control::Base base, const DynamicsOptions& options) {
  const control::TreeDescription tree = read_tree(file);
  const control::Mechanism mechanism(tree, Eigen::Vector3d(0.0, 0.0, -9.81), {base, {}});
  FlatRobot written = as_written(tree, mechanism);
  const FlatRobot moving = merged(mechanism);
  const Peer& kdl = load(options.peers, "libbench_peer_kdl.so");
  const Peer& mujoco = load(options.peers, "libbench_peer_mujoco.so");
  Course course;
  course.name = std::filesystem::path(file).stem().string();
  course.nq = mechanism.nq();
  course.dof = mechanism.dof();
  if (!options.compiled.empty()) {
    const auto compiled = std::filesystem::path(options.compiled) / (course.name + ".so");
    written.compiled = std::filesystem::exists(compiled) ? compiled.string() : "";
  }
  const auto add = [&](const std::string& name, const Peer& peer, const FlatRobot& robot) {
    course.contenders.push_back(std::make_unique<Contender>(name, peer, robot.robot()));
  };
  add(our_peer().name, our_peer(), written);
  add(compiled_peer().name, compiled_peer(), written);
  add(kdl.name, kdl, written);
  add(fmt::format("{} merged", kdl.name), kdl, moving);
  add(mujoco.name, mujoco, moving);

  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-3.0, 3.0);
  std::uniform_real_distribution<double> rate(-2.0, 2.0);
  const std::size_t count = kStates * static_cast<std::size_t>(course.dof);
  for (std::size_t i = 0; i < kStates; ++i) {
    const auto first = static_cast<Eigen::Index>(course.q.size());
    for (int k = 0; k < course.nq; ++k) {
      course.q.push_back(angle(random));
    }
    if (base == control::Base::kFloating) {
      Eigen::Map<Eigen::Vector4d>(course.q.data() + first + 3).normalize();
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    course.v.push_back(rate(random));
    course.x.push_back(rate(random));
  }
  course.out.resize(static_cast<std::size_t>(course.dof * course.dof));
  return course;
}

/// Robots on a fixed base first, then those that float.
Course set_up_number(std::size_t i, const DynamicsOptions& options) {
  const std::size_t fixed = options.robots.size();
  return i < fixed ? set_up(options.robots[i], control::Base::kFixed, options)
                   : set_up(options.floating.at(i - fixed), control::Base::kFloating, options);
}

std::size_t result_size(const Course& course, PeerFunction f) {
  const auto n = static_cast<std::size_t>(course.dof);
  return f == kMassMatrix || f == kCoriolisMatrix || f == kMetricInverse ? n * n : n;
}

/// Adds to `worst` each contender's largest difference from ours, relative to the largest entry.
/// @throws std::runtime_error beyond what the library allows itself.
void compare(Course& course, PeerFunction f, std::map<std::string, double>& worst) {
  for (std::size_t state = 0; state < kStates; ++state) {
    course.run(*course.contenders.front(), f, state);
    const std::vector<double> ours = course.out;
    for (const auto& who : course.contenders) {
      if (!who->has(f)) {
        continue;
      }
      course.run(*who, f, state);
      double scale = 0.0;
      double difference = 0.0;
      for (std::size_t i = 0; i < result_size(course, f); ++i) {
        scale = std::max(scale, std::abs(ours[i]));
        difference = std::max(difference, std::abs(course.out[i] - ours[i]));
      }
      if (!(difference <= who->agreement() * scale)) {
        throw std::runtime_error(
            fmt::format("{} of {} by {} differs from ours by {:.1e} of its largest entry: one of "
                        "the two is called wrongly, so nothing is timed",
                        kNames[f], course.name, who->name(), difference / scale));
      }
      double& so_far = worst[who->name()];
      so_far = std::max(so_far, difference / scale);
    }
  }
}

/// All states, `repeats` times. @return ns a call.
double turn(Course& course, const Contender& who, PeerFunction f, int repeats) {
  const std::int64_t begin = rt::now_ns();
  for (int i = 0; i < repeats; ++i) {
    for (std::size_t state = 0; state < kStates; ++state) {
      course.run(who, f, state);
    }
  }
  return static_cast<double>(rt::now_ns() - begin) /
         (static_cast<double>(repeats) * static_cast<double>(kStates));
}

Timing timing(bool cold, PeerFunction f, const Contender& who, std::vector<double>& ns) {
  std::sort(ns.begin(), ns.end());
  const std::size_t n = ns.size();
  return {cold, kNames[f], who.name(), ns.front(), ns[n / 2], ns[n * 9 / 10]};
}

void time_function(Course& course, PeerFunction f, const DynamicsOptions& options,
                   std::vector<Timing>& timings) {
  struct Entrant {
    const Contender* who;
    int repeats;
    std::vector<double> ns;
  };
  std::vector<Entrant> entrants;
  for (const auto& who : course.contenders) {
    if (who->has(f)) {
      turn(course, *who, f, 2);  // warm
      const double ns = turn(course, *who, f, 2) * static_cast<double>(kStates);
      entrants.push_back(
          {who.get(), std::max(1, static_cast<int>(options.slice_us * 1e3 / ns)), {}});
    }
  }
  for (int round = 0; round < options.rounds; ++round) {
    for (Entrant& entrant : entrants) {
      entrant.ns.push_back(turn(course, *entrant.who, f, entrant.repeats));
    }
  }
  for (Entrant& entrant : entrants) {
    timings.push_back(timing(false, f, *entrant.who, entrant.ns));
  }
}

/// Memory larger than any cache; passing over it leaves nothing else in them.
class Sweep {
 public:
  void operator()() {
    for (std::size_t i = 0; i < memory_.size(); i += kLine) {
      memory_[i] = static_cast<unsigned char>(memory_[i] + 1U);
    }
  }

 private:
  static constexpr std::size_t kLine = 64;
  std::vector<unsigned char> memory_ = std::vector<unsigned char>(std::size_t{128} << 20U);
};

/// One call a round, after a sweep, as in a loop that sleeps between cycles while others work.
void time_cold(Course& course, PeerFunction f, const DynamicsOptions& options, Sweep& sweep,
               std::vector<Timing>& timings) {
  std::map<const Contender*, std::vector<double>> ns;
  for (int round = 0; round < options.cold_rounds; ++round) {
    for (const auto& who : course.contenders) {
      if (who->has(f)) {
        sweep();
        rt::now_ns();  // the clock itself is warm
        const std::int64_t begin = rt::now_ns();
        course.run(*who, f, static_cast<std::size_t>(round) % kStates);
        ns[who.get()].push_back(static_cast<double>(rt::now_ns() - begin));
      }
    }
  }
  for (const auto& who : course.contenders) {
    if (const auto found = ns.find(who.get()); found != ns.end()) {
      timings.push_back(timing(true, f, *who, found->second));
    }
  }
}

}  // namespace

std::vector<RobotTimings> measure_dynamics(const DynamicsOptions& options) {
  std::vector<RobotTimings> all;
  Sweep sweep;
  for (std::size_t i = 0; i < options.robots.size() + options.floating.size(); ++i) {
    Course course = set_up_number(i, options);
    RobotTimings& robot = all.emplace_back();
    robot.robot = course.name;
    robot.dof = course.dof;
    for (const auto& who : course.contenders) {
      if (who->why_not() != nullptr) {
        robot.absent.push_back(fmt::format("{}: {}", who->name(), who->why_not()));
      }
    }
    for (unsigned f = 0; f < kPeerFunctions; ++f) {
      const auto function = static_cast<PeerFunction>(f);
      compare(course, function, robot.differences);
    }
    for (unsigned f = 0; f < kPeerFunctions; ++f) {
      time_function(course, static_cast<PeerFunction>(f), options, robot.timings);
    }
    for (const PeerFunction f : {kBias, kGravity, kMassMatrix}) {
      if (options.cold_rounds > 0) {
        time_cold(course, f, options, sweep, robot.timings);
      }
    }
  }
  return all;
}

void call_only(const DynamicsOptions& options, const std::string& who, const std::string& function,
               long calls) {
  Course course = set_up_number(0, options);
  const auto f = std::find(kNames.begin(), kNames.end(), function);
  const auto contender = std::find_if(course.contenders.begin(), course.contenders.end(),
                                      [&](const auto& each) { return each->name() == who; });
  if (f == kNames.end() || contender == course.contenders.end()) {
    throw std::runtime_error(fmt::format("there is no {} of {}", function, who));
  }
  const auto which = static_cast<PeerFunction>(f - kNames.begin());
  for (long call = 0; call < calls; ++call) {
    course.run(**contender, which, static_cast<std::size_t>(call) % kStates);
  }
}

}  // namespace geodesic::bench
