#include "ensemble/ensemble_runner.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace granuscope {
namespace {

/// Threads of this process.
int threads_now() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("Threads:")) return std::atoi(line.c_str() + 8);
  }
  return -1;
}

TEST_CASE("every index is handled once, and no more threads are started than there are indices") {
  constexpr std::size_t count = 5;
  std::vector<std::atomic<int>> handled(count);
  std::atomic<int> most = 0;
  const int before = threads_now();
  REQUIRE(before >= 1);
  for_each_index(count, 3000, [&](std::size_t i) {
    ++handled[i];
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const int now = threads_now();
    for (int known = most; now > known && !most.compare_exchange_weak(known, now);) {
    }
  });
  for (const std::atomic<int>& times : handled) CHECK(times == 1);
  CHECK(most <= before + static_cast<int>(count));
  int bodies = 0;
  for_each_index(0, 4, [&](std::size_t) { ++bodies; });
  CHECK(bodies == 0);
}

}  // namespace
}  // namespace granuscope
