#pragma once
#include <functional>
#include <string>
#include <vector>

#include "mpi/ranks.h"
#include "pipeline/crew.h"

namespace granuscope {

/// The ranks of an MPI program as a crew. Rank 0 runs the command and calls draw(); the others follow it. All take
/// blocks from one shared counter, the dearest first, so that slow machines take fewer. Each writes the blocks it has
/// drawn into the run's folder, which all must see, and puts them at their places in the ensemble (placed_blocks.h);
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
