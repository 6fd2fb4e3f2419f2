#include "ensemble/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <utility>
#include <vector>

namespace granuscope {
namespace {

/// Whether this thread runs a body: what a body repeats it repeats alone, since the others are at work already.
thread_local bool inside_body = false;

}  // namespace

void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const std::size_t allowed = threads > 0 ? static_cast<std::size_t>(threads) : std::thread::hardware_concurrency();
  // Threads without work would still be started, thousands of them in the worst case.
  const std::size_t wanted = inside_body ? 1 : std::clamp<std::size_t>(count, 1, std::max<std::size_t>(1, allowed));

  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
  const auto work = [&] {
    const bool was_inside = std::exchange(inside_body, true);
    try {
      for (std::size_t i = next++; i < count && !failed; i = next++) body(i);
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
    inside_body = was_inside;
  };
  {
    std::vector<std::jthread> others;  // joined at the end of the block, also when one cannot be started
    others.reserve(wanted - 1);
    try {
      while (others.size() + 1 < wanted) others.emplace_back(work);
    } catch (...) {
      failed = true;
      throw;
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace granuscope
