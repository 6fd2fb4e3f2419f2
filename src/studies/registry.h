#pragma once
#include <memory>
#include <vector>

#include "studies/study.h"

namespace granuscope {

/// All studies that there are, in the order of the report, with their settings: a value, which copies what it holds.
class Studies {
 public:
  Studies();
  Studies(const Studies& other);
  Studies& operator=(const Studies& other);
  Studies(Studies&&) = default;
  Studies& operator=(Studies&&) = default;

  auto begin() { return all_.begin(); }
  auto end() { return all_.end(); }
  auto begin() const { return all_.begin(); }
  auto end() const { return all_.end(); }

  /// The ensembles of all that are asked for, in their order.
  std::vector<StudyEnsemble> ensembles(const MainLine& main) const;

 private:
  std::vector<std::unique_ptr<Study>> all_;
};

}  // namespace granuscope
