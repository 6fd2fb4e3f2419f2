#include "sampling/group_lanes.h"

#include <x86intrin.h>

#include <chrono>
#include <numeric>

#if defined(__x86_64__)
#endif

namespace granuscope {
namespace {

thread_local PhaseTimes* of_this_thread = nullptr;

/// A clock that is read as fast as the machine allows.
std::uint64_t ticks() {
#if defined(__x86_64__)
  return __rdtsc();
#else
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

}  // namespace

PhaseTimes::PhaseTimes() : outer_(of_this_thread) { of_this_thread = this; }
PhaseTimes::~PhaseTimes() { of_this_thread = outer_; }
PhaseTimes* PhaseTimes::current() { return of_this_thread; }
void PhaseTimes::begin() { last_ = ticks(); }

void PhaseTimes::end(Phase phase) {
  const std::uint64_t now = ticks();
  ticks_[static_cast<std::size_t>(phase)] += now - last_;
  last_ = now;
}

std::array<double, phases> PhaseTimes::shares() const {
  const auto all = static_cast<double>(std::accumulate(ticks_.begin(), ticks_.end(), std::uint64_t{0}));
  std::array<double, phases> shares{};
  for (std::size_t p = 0; p < phases && all > 0; ++p) shares[p] = static_cast<double>(ticks_[p]) / all;
  return shares;
}

}  // namespace granuscope
