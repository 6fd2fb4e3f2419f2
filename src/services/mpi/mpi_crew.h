#pragma once
#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/sample_stage.h"

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

/// The ranks of an MPI program as a crew. Rank 0 runs the command and calls draw(); the others follow it. All take
/// blocks from one shared counter, the dearest first, so that slow machines take fewer. Each writes the blocks it has
/// drawn into the run's folder, which all must see, and puts them at their places in the ensemble (block_files.h);
/// nothing but the numbers of blocks and notes about them goes through the network.
class MpiCrew : public Crew {
 public:
  explicit MpiCrew(Ranks& ranks) : ranks_(ranks) {}

  void draw(const Experiment& experiment, const RunOptions& options,
            const std::vector<PlannedEnsemble>& ensembles) override;

  /// Rank 0: the others end with this status.
  void end(int code);
  /// The other ranks: draw what rank 0 asks for until it ends; returns its status.
  int follow();

 private:
  /// `finish` is handed on rank 0 what each rank tells of the blocks that it has put at their places.
  void work(const std::string& task, ProgressStyle style,
            const std::function<void(const std::vector<std::string>&)>& finish);

  Ranks& ranks_;
};

}  // namespace granuscope
