// The thread that looks after the buses.
#include "tools/geodesicd/bus_keeper.hpp"

#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "drivers/bus/unix_address.hpp"
#include "rt/capabilities.hpp"

namespace geodesic::tools {
namespace {

// Often enough that a bus that stands still is emptied within a few cycles of being found so.
constexpr std::chrono::milliseconds kRound{5};
// Nobody reads: what is newest is dropped.
constexpr std::size_t kMostNews = 256;

}  // namespace

BusKeeper::BusKeeper(drivers::Arm& arm, const std::vector<drivers::BusOptions>& buses) : arm_(arm) {
  const bool administers = std::any_of(buses.begin(), buses.end(), [](const auto& bus) {
    return bus.bring_up && !drivers::is_socket_bus(bus.interface);
  });
  look();  // what opening had to tell; from here on the buses are tended
  thread_ = std::thread([this, administers] { run(administers); });
  while (!settled_.load()) {  // its capabilities are as they will be
    std::this_thread::yield();
  }
}

BusKeeper::~BusKeeper() {
  stop_.store(true);
  thread_.join();
}

void BusKeeper::run(bool administers) {
  ::prctl(PR_SET_NAME, "geodesic-link");
  if (administers && rt::keep_only_network_administration()) {
    privileged_.store(static_cast<int>(::gettid()));
  } else {
    rt::drop_thread_capabilities();
  }
  settled_.store(true);
  while (!stop_.load(std::memory_order_relaxed)) {
    look();
    std::this_thread::sleep_for(kRound);
  }
}

void BusKeeper::look() {
  arm_.tend();
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < arm_.buses(); ++i) {
    health_[i] = arm_.bus_health(i);
    std::vector<drivers::BusNews> news = arm_.take_bus_news(i);
    const std::size_t room = kMostNews - std::min(news_.size(), kMostNews);
    news_.insert(news_.end(), std::make_move_iterator(news.begin()),
                 std::make_move_iterator(news.begin() +
                                         static_cast<std::ptrdiff_t>(std::min(room, news.size()))));
  }
}

BusKeeper::Health BusKeeper::health() const {
  const std::lock_guard lock(mutex_);
  return health_;
}

std::vector<drivers::BusNews> BusKeeper::take_news() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, {});
}

}  // namespace geodesic::tools
