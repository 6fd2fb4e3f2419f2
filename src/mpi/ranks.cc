#include "mpi/ranks.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <thread>

#include "support/interruption.h"

namespace granuscope {

Ranks::Ranks() {
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &local_);
  MPI_Comm_free(&machine);
  MPI_Win_allocate(rank_ == 0 ? 2 * static_cast<MPI_Aint>(sizeof(std::int64_t)) : 0, sizeof(std::int64_t),
                   MPI_INFO_NULL, MPI_COMM_WORLD, static_cast<void*>(&counters_), &window_);
  MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
}

void Ranks::close() {
  MPI_Win_unlock_all(window_);
  MPI_Win_free(&window_);
}

void Ranks::wait(MPI_Request request) {
  using namespace std::chrono_literals;
  auto pause = 20us;
  for (;;) {
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done != 0) return;
    throw_if_interrupted();
    std::this_thread::sleep_for(pause);
    pause = std::min<std::chrono::microseconds>(2 * pause, 2ms);
  }
}

// NOLINTBEGIN(clang-analyzer-optin.mpi.MPI-Checker): each request is waited for in wait(), which it cannot see.

std::string Ranks::broadcast(std::string bytes, int from) {
  std::uint64_t size = bytes.size();
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&size, 1, MPI_UINT64_T, from, MPI_COMM_WORLD, &request);
  wait(request);
  bytes.resize(size);
  MPI_Ibcast(bytes.data(), static_cast<int>(size), MPI_BYTE, from, MPI_COMM_WORLD, &request);
  wait(request);
  return bytes;
}

std::vector<std::string> Ranks::gather(std::string bytes) {
  const auto size = static_cast<int>(bytes.size());
  const auto ranks = static_cast<std::size_t>(rank_ == 0 ? size_ : 0);
  std::vector<int> sizes(ranks), places(ranks);
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Igather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
  wait(request);
  std::exclusive_scan(sizes.begin(), sizes.end(), places.begin(), 0);
  std::string all(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}), '\0');
  MPI_Igatherv(bytes.data(), size, MPI_BYTE, all.data(), sizes.data(), places.data(), MPI_BYTE, 0, MPI_COMM_WORLD,
               &request);
  wait(request);
  std::vector<std::string> each;
  for (std::size_t i = 0; i < ranks; ++i) {
    each.push_back(all.substr(static_cast<std::size_t>(places[i]), static_cast<std::size_t>(sizes[i])));
  }
  return each;
}

int Ranks::largest(int value) {
  int result = value;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(&value, &result, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD, &request);
  wait(request);
  return result;
}

int Ranks::smallest(int value) { return -largest(-value); }

void Ranks::reset_counters() {
  for (const Counter counter : {taken, finished}) {
    if (rank_ != 0) continue;
    const std::int64_t before = add(counter, 0);
    add(counter, -before);
  }
  wait_for_all();
}

void Ranks::wait_for_all() {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  wait(request);
}

std::int64_t Ranks::add(Counter counter, std::int64_t value) {
  std::int64_t before = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  // Fetch and add; unlike MPI_Fetch_and_op this can be waited for without blocking.
  MPI_Rget_accumulate(&value, 1, MPI_INT64_T, &before, 1, MPI_INT64_T, 0, counter, 1, MPI_INT64_T, MPI_SUM, window_,
                      &request);
  wait(request);
  return before;
}

// NOLINTEND(clang-analyzer-optin.mpi.MPI-Checker)

void Ranks::attend() {
  int message = 0;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &message, MPI_STATUS_IGNORE);
}

}  // namespace granuscope
