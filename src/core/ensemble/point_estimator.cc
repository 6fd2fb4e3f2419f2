#include "ensemble/estimator.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "model/audit.h"
#include "sampling/pile_group.h"

namespace granuscope {
namespace {

const char* quantity_of(const EnsembleSpec& spec) { return moves_loads(spec) ? "moved_weight" : "weight"; }

}  // namespace

std::vector<QuantityShape> PointEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerObservables::quantities(spec);
  if (spec.record_profiles) all.push_back({quantity_of(spec), response_columns(spec)});
  if (spec.record_forces) std::ranges::copy(ForceCounts::quantities(), std::back_inserter(all));
  return all;
}

PointEstimator::PointEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block)
    : spec_(spec),
      moves_(moves_loads(spec)),
      // Whole groups, so that what one shares is known.
      loads_(std::max(piles_at_once(spec), moves_ ? std::size_t{group_size} : 1), top_load(spec)),
      beads_(loads_.size()),
      shared_(static_cast<std::size_t>(spec.lattice.columns)),
      sampler_(samplers.first),
      layers_(sums.layers),
      observables_(spec, sums, block),
      profiles_(spec.record_profiles),
      weight_(profiles_ ? BlockSlice(sums, quantity_of(spec), block) : BlockSlice()) {
  if (spec.record_forces) forces_.emplace(spec, sums, block);
}

std::optional<SamplingFailure> PointEstimator::measure(std::uint64_t sample) {
  std::optional<SamplingFailure> failure;
  measure_samples({&sample, 1}, {&failure, 1});
  return failure;
}

void PointEstimator::choose_loads(std::span<const std::uint64_t> samples) {
  numbers_.clear();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    numbers_.push_back(numbers_of(spec_, samples[k]));
    beads_[k] = overloaded_bead(spec_, samples[k]);
    if (spec_.response.coupled) loads_[k] = top_load(spec_, beads_[k]);
  }
}

void PointEstimator::measure_samples(std::span<const std::uint64_t> samples,
                                     std::span<std::optional<SamplingFailure>> failures) {
  for (std::size_t done = 0; done < samples.size(); done += loads_.size()) {
    const std::size_t count = std::min(loads_.size(), samples.size() - done);
    choose_loads(samples.subspan(done, count));
    const std::vector<std::span<const double>> loads(loads_.begin(),
                                                     loads_.begin() + static_cast<std::ptrdiff_t>(count));
    const auto of_these = failures.subspan(done, count);
    const auto groups = sampler_.draw_groups(numbers_, loads, of_these);
    std::size_t first = 0;
    for (const PileGroup& group : groups) {
      const auto of_group = of_these.subspan(first, group.piles);
      assert_identities(group, of_group);
      observables_.add(group, of_group);
      if (forces_) forces_->add(group, of_group);
      if (profiles_ && !moves_) add_weights(group, of_group);
      first += group.piles;
    }
    if (profiles_ && moves_) add_moved(groups, of_these);
  }
}

void PointEstimator::add_weights(const PileGroup& group, Failures failures) {
  const auto columns = static_cast<std::size_t>(group.lattice.columns());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = group.row(layers_[l]);
    const double of_beads = group.weight_of_beads(layers_[l]);
    for (std::size_t i = 0; i < columns; ++i) {
      for (std::size_t k = 0; k < group.piles; ++k) {
        if (!failures[k]) weight_.add(l, i, group.weight(row + i * group.stride + k) - of_beads);
      }
    }
  }
}

void PointEstimator::add_moved(std::span<const PileGroup> groups, Failures failures) {
  // The piles one after the other, and those that share their numbers.
  struct Place {
    const PileGroup* group;
    std::size_t lane;
  };
  std::vector<Place> piles;
  for (const PileGroup& group : groups) {
    for (std::size_t k = 0; k < group.piles; ++k) piles.push_back({&group, k});
  }
  const std::size_t columns = shared_.size(), part = static_cast<std::size_t>(response_columns(spec_));
  for (std::size_t begin = 0, end = 0; begin < piles.size(); begin = end) {
    end = begin + 1;
    while (end < piles.size() && numbers_[end] == numbers_[begin]) ++end;
    const auto alive =
        static_cast<double>(std::count(failures.begin() + static_cast<std::ptrdiff_t>(begin),
                                       failures.begin() + static_cast<std::ptrdiff_t>(end), std::nullopt));
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      // Calls body(i, weight of bead i) for the beads of the layer.
      const auto for_each_weight = [&](std::size_t pile, auto body) {
        const PileGroup& group = *piles[pile].group;
        std::size_t entry = group.row(layers_[l]) + piles[pile].lane;
        for (std::size_t i = 0; i < columns; ++i, entry += group.stride) body(i, group.weight(entry));
      };
      const double mean = mean_weight(spec_.sampler.bead_weight, layers_[l]);
      std::ranges::fill(shared_, spec_.response.coupled ? 0 : mean);
      for (std::size_t pile = begin; spec_.response.coupled && pile < end; ++pile) {
        if (!failures[pile]) for_each_weight(pile, [&](std::size_t i, double weight) { shared_[i] += weight / alive; });
      }
      for (std::size_t pile = begin; pile < end; ++pile) {
        if (failures[pile]) continue;
        // The overloaded bead comes to stand in the middle of the part.
        std::size_t to = (part / 2 + part - static_cast<std::size_t>(beads_[pile]) % part) % part;
        for_each_weight(pile, [&](std::size_t i, double weight) {
          weight_.add(l, to, weight - shared_[i]);
          if (++to == part) to = 0;
        });
      }
    }
  }
}

namespace {

bool below_overload(const Lattice& lattice, int layer, int bead) {
  return std::abs(lattice.x(layer, bead)) <= lattice.z(layer);
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
  all.push_back({"failing_again", 1});
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
      failing_again_(sums, "failing_again", block),
      response_thrust_(sums, "response_thrust", block),
      profiles_(spec.record_profiles),
      response_(profiles_ ? BlockSlice(sums, "response", block) : BlockSlice()) {
  overloaded_[static_cast<std::size_t>(before_.lattice.middle())] += overload_;
}

namespace {

/// Those whose parents had to change, or that had to backtrack.
std::uint64_t repaired_beads(const SamplerCounts& counts) {
  return counts.repaired_by_pair + counts.repaired_by_arc + counts.repaired_by_ring + counts.backtracked;
}

}  // namespace

std::optional<SamplingFailure> PairedEstimator::draw(std::uint64_t sample) {
  if (const auto failure = samplers_.first.draw(sample, uniform_load_, before_)) return failure;
  const std::uint64_t so_far = repaired_beads(samplers_.second.counts());
  const auto failure = samplers_.second.draw_again(sample, overloaded_, before_, after_);
  failed_again_ = repaired_beads(samplers_.second.counts()) - so_far;
  return failure;
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
    failing_again_.add(l, static_cast<double>(failed_again_) / static_cast<double>(lattice.beads()));
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
    response_thrust_.add(l, after_.lattice.geometry().cotangent * difference / overload_);
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

void measure_rearrangements(const Lattice& lattice, const std::vector<unsigned char>& redrawn,
                            std::vector<int>& beads) {
  beads.assign(redrawn.size(), 0);
  std::vector<std::size_t> waiting;
  std::vector<std::size_t> found;
  for (std::size_t start = 0; start < redrawn.size(); ++start) {
    if (redrawn[start] == 0 || beads[start] != 0) continue;
    const auto visit = [&](int layer, int bead) {
      const std::size_t at = lattice.index(layer, bead);
      if (redrawn[at] == 0 || beads[at] != 0) return;
      beads[at] = 1;
      found.push_back(at);
      waiting.push_back(at);
    };
    const auto columns = static_cast<std::size_t>(lattice.columns());
    found.clear();
    visit(static_cast<int>(start / columns), static_cast<int>(start % columns));
    while (!waiting.empty()) {
      const int layer = static_cast<int>(waiting.back() / columns), bead = static_cast<int>(waiting.back() % columns);
      waiting.pop_back();
      if (layer > 0) {
        visit(layer - 1, lattice.upper_left(layer, bead));
        visit(layer - 1, lattice.upper_right(layer, bead));
      }
      if (layer + 1 < lattice.layers()) {
        visit(layer + 1, lattice.lower_left(layer, bead));
        visit(layer + 1, lattice.lower_right(layer, bead));
      }
    }
    for (const std::size_t at : found) beads[at] = static_cast<int>(found.size());
  }
}

}  // namespace granuscope
