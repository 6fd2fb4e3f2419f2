#pragma once
#include "ensemble/ensemble_runner.h"
#include "kit/same_bytes.h"

namespace granuscope::test {

/// Of 64 piles in 8 blocks, 30 layers deep.
inline EnsembleSpec small_ensemble(const ResponseSpec& response, int columns) {
  EnsembleSpec spec;
  spec.response = response;
  spec.response.samples = 64;
  spec.response.blocks = 8;
  spec.sampler.mu = 0.3;
  spec.sampler.seed = 7;
  spec.lattice = {.columns = columns, .layers = 30};
  return spec;
}

/// What is recorded, what failed and what it cost.
inline bool same_bytes(const EnsembleRecord& a, const EnsembleRecord& b) {
  if (a.configuration != b.configuration || a.sums.layers != b.sums.layers || a.sums.count != b.sums.count)
    return false;
  if (a.sums.quantities.size() != b.sums.quantities.size() || a.failed.size() != b.failed.size()) return false;
  for (const auto& [name, sums] : a.sums.quantities) {
    const QuantitySums& other = b.sums.quantities.at(name);
    if (!same_bytes(sums.sum, other.sum) || !same_bytes(sums.sum_of_squares, other.sum_of_squares)) return false;
  }
  for (std::size_t k = 0; k < a.failed.size(); ++k) {
    if (a.failed[k].sample != b.failed[k].sample || a.failed[k].layer != b.failed[k].layer) return false;
  }
  return a.counts.uniforms == b.counts.uniforms && a.counts.pairs == b.counts.pairs &&
         a.counts.beads == b.counts.beads && a.counts.backtracks == b.counts.backtracks;
}

}  // namespace granuscope::test
