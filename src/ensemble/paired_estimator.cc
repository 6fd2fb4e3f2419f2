#include "ensemble/paired_estimator.h"

#include <algorithm>
#include <cmath>

#include "ensemble/rearrangements.h"
#include "model/identities.h"
#include "sampling/split_uniforms.h"

namespace granuscope {
namespace {

bool below_overload(const Lattice& lattice, int layer, int bead) {
  return std::abs(lattice.x(layer, bead)) <= Lattice::depth(layer);
}

}  // namespace

int beads_below_overload(const Lattice& lattice, int layer) {
  int beads = 0;
  for (int i = 0; i < lattice.columns(); ++i) beads += below_overload(lattice, layer, i) ? 1 : 0;
  return beads;
}

std::vector<QuantityShape> PairedEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerObservables::quantities(spec);
  all.push_back({"redrawn", 1});
  all.push_back({"redrawn_below_overload", 1});
  all.push_back({"least_force", 1});
  all.push_back({"redrawn_force", 1});
  all.push_back({"redrawn_together", 1});
  all.push_back({"response_thrust", 1});
  if (spec.record_profiles) all.push_back({"response", spec.lattice.columns});
  return all;
}

PairedEstimator::PairedEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block)
    : overload_(spec.response.overload),
      uniform_load_(static_cast<std::size_t>(spec.lattice.columns), 1.0),
      overloaded_(uniform_load_),
      samplers_(samplers),
      before_(Lattice(spec.lattice)),
      after_(before_),
      layers_(sums.layers),
      observables_(spec, sums, block),
      redrawn_(sums, "redrawn", block),
      redrawn_below_(sums, "redrawn_below_overload", block),
      least_force_(sums, "least_force", block),
      redrawn_force_(sums, "redrawn_force", block),
      redrawn_together_(sums, "redrawn_together", block),
      response_thrust_(sums, "response_thrust", block),
      profiles_(spec.record_profiles),
      response_(profiles_ ? BlockSlice(sums, "response", block) : BlockSlice()) {
  overloaded_[static_cast<std::size_t>(before_.lattice.middle())] += overload_;
}

std::optional<SamplingFailure> PairedEstimator::draw(std::uint64_t sample) {
  if (const auto failure = samplers_.first.draw(sample, uniform_load_, before_)) return failure;
  return samplers_.second.draw_again(sample, overloaded_, before_, after_);
}

std::optional<SamplingFailure> PairedEstimator::measure(std::uint64_t sample) {
  if (const auto failure = draw(sample)) return failure;
  assert_identities(before_);
  assert_identities(after_);
  observables_.add(before_);
  add_redrawn();
  add_response_thrust();
  if (profiles_) add_response();
  return std::nullopt;
}

void PairedEstimator::add_redrawn() {
  find_redrawn(before_, after_, beads_redrawn_);
  const Lattice& lattice = after_.lattice;
  measure_rearrangements(lattice, beads_redrawn_, rearranged_);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const int layer = layers_[l];
    int everywhere = 0, below = 0, beads_below = 0;
    double force = 0, of_redrawn = 0, together = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t at = lattice.index(layer, i);
      const int redrawn = beads_redrawn_[at];
      everywhere += redrawn;
      together += rearranged_[at];
      const double least = std::min(before_.V_R[at], before_.V_L[at]);
      force += least;
      of_redrawn += redrawn * least;
      if (!below_overload(lattice, layer, i)) continue;
      below += redrawn;
      ++beads_below;
    }
    redrawn_.add(l, static_cast<double>(everywhere) / lattice.columns());
    redrawn_below_.add(l, static_cast<double>(below) / beads_below);
    least_force_.add(l, force / lattice.columns());
    redrawn_force_.add(l, of_redrawn / lattice.columns());
    redrawn_together_.add(l, together / lattice.columns());
  }
}

void PairedEstimator::add_response_thrust() {
  const auto columns = static_cast<std::size_t>(after_.lattice.columns());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = after_.lattice.index(layers_[l], 0);
    double difference = 0;
    for (std::size_t i = row; i < row + columns; ++i) {
      difference += (after_.H_R[i] - after_.H_L[i]) - (before_.H_R[i] - before_.H_L[i]);
    }
    response_thrust_.add(l, sqrt3 * difference / overload_);
  }
}

void PairedEstimator::add_response() {
  const auto columns = static_cast<std::size_t>(after_.lattice.columns());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = after_.lattice.index(layers_[l], 0);
    for (std::size_t i = 0; i < columns; ++i) {
      const double with = after_.V_R[row + i] + after_.V_L[row + i];
      const double without = before_.V_R[row + i] + before_.V_L[row + i];
      response_.add(l, i, (with - without) / overload_);
    }
  }
}

}  // namespace granuscope
