#pragma once
#include <mpi.h>

#include <cstdint>
#include <string>
#include <vector>

namespace granuscope {

/// The processes of an MPI program. Nothing here blocks inside the library: a rank that waits looks now and then
/// whether it is asked to stop, and then throws Interrupted, so that the end of one rank is not the hanging of the
/// others.
class Ranks {
 public:
  /// Between MPI_Init and MPI_Finalize, on the thread that called the former, like all that follows.
  Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }
  /// Ranks on this machine.
  int on_this_machine() const { return local_; }

  /// The bytes of rank `from`, on every rank.
  std::string broadcast(std::string bytes, int from = 0);
  /// The bytes of every rank, in order, on rank 0; nothing on others.
  std::vector<std::string> gather(std::string bytes);
  int largest(int value);
  int smallest(int value);
  /// Returns when all ranks have come here.
  void wait_for_all();

  // Two shared counters, kept by rank 0.
  enum Counter { taken, finished };
  /// Sets both to 0; all ranks have done so when it returns.
  void reset_counters();
  /// Adds to a counter, and returns what it was before.
  std::int64_t add(Counter counter, std::int64_t value);
  /// Lets the library answer others while this rank waits for something else.
  void attend();

  /// Gives up the counters before MPI_Finalize.
  void close();

 private:
  void wait(MPI_Request request);

  int rank_ = 0, size_ = 1, local_ = 1;
  MPI_Win window_ = MPI_WIN_NULL;
  std::int64_t* counters_ = nullptr;
};

}  // namespace granuscope
