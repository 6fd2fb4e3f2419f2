#include "support/progress.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

namespace granuscope {

TEST_CASE("processor time passes while this thread works, and neither while it sleeps nor while another one works") {
  const auto work = [] {
    const double start = processor_seconds();
    while (processor_seconds() < start + 0.05) {
    }
  };
  const double before = processor_seconds();
  work();
  const double worked = processor_seconds();
  CHECK(worked - before >= 0.05);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  std::thread(work).join();
  CHECK(processor_seconds() - worked < 0.03);
}

}  // namespace granuscope
