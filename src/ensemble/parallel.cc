#include "ensemble/parallel.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

namespace granuscope {

void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const int allowed = threads > 0 ? threads : tbb::info::default_concurrency();
  // Threads without work would still be started, thousands of them in the worst case.
  const int wanted = static_cast<int>(std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(allowed)));
  // Without the control TBB keeps to the machine's number and complains on stderr about more.
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(wanted));
  tbb::task_arena arena(wanted);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, body, tbb::simple_partitioner()); });
}

}  // namespace granuscope
