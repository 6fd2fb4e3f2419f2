#include "sampling/sampler.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "sampling/diluted_beads.h"
#include "sampling/granusolve.h"
#include "sampling/polytope.h"
#include "sampling/random_key.h"
#include "sampling/row_model.h"
#include "sampling/simple_laws.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Every law at mu = 0, where the only solution is the frictionless pile.
class FrictionlessSampler final : public Sampler {
 public:
  FrictionlessSampler(const SamplerSpec& spec, const Lattice& lattice) : Sampler(lattice), spec_(spec) {}
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override {
    begin_pile(spec_, spec_.law, sample, load, pile);
    fill_frictionless(load, pile);
    ++counts_.tries;
    counts_.beads += pile.lattice.beads();
    return std::nullopt;
  }

 private:
  SamplerSpec spec_;
};

/// Guards the contract of draw() once, for every law.
class CheckedSampler final : public Sampler {
 public:
  CheckedSampler(std::unique_ptr<Sampler> inner, const Lattice& lattice, bool takes_zero)
      : Sampler(lattice), inner_(std::move(inner)), takes_zero_(takes_zero) {}
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override {
    check(sample, load, pile);
    auto failure = inner_->draw(sample, load, pile);
    counts_ += inner_->take_counts();
    return failure;
  }
  std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load, const Pile& first,
                                            Pile& pile) override {
    check(sample, load, pile);
    if (&first == &pile || first.H_R.size() != lattice_.beads()) {
      throw std::logic_error("a sampler was handed a first pile of another lattice, or one and the same pile twice");
    }
    auto failure = inner_->draw_again(sample, load, first, pile);
    counts_ += inner_->take_counts();
    return failure;
  }
  std::span<const PileGroup> draw_groups(std::span<const std::uint64_t> samples,
                                         std::span<const std::span<const double>> loads,
                                         std::span<std::optional<SamplingFailure>> failures) override {
    if (loads.size() != samples.size() || failures.size() != samples.size()) {
      throw std::logic_error("a sampler was handed different numbers of samples, loads and places for failures");
    }
    for (std::size_t k = 0; k < samples.size(); ++k) check(samples[k], loads[k]);
    const auto groups = inner_->draw_groups(samples, loads, failures);
    counts_ += inner_->take_counts();
    return groups;
  }

  void keep_layers(const KeptLayers& kept) override {
    const std::vector<int>& layers = kept.layers;
    const bool ascending = std::adjacent_find(layers.begin(), layers.end(), std::greater_equal<>()) == layers.end();
    if (layers.empty() || !ascending || layers.front() < 0 || layers.back() >= lattice_.layers()) {
      throw std::logic_error("a sampler was told to keep layers that the pile does not have, or in no order");
    }
    inner_->keep_layers(kept);
  }

 private:
  void check(std::uint64_t sample, std::span<const double> load, const Pile& pile) const {
    if (pile.V_R.size() != lattice_.beads()) throw std::logic_error("a sampler was handed a pile of another lattice");
    check(sample, load);
  }

  void check(std::uint64_t sample, std::span<const double> load) const {
    if (sample >= max_samples) {
      throw InputError("sample {} is out of range: one seed names {} samples; use another seed", sample, max_samples);
    }
    if (load.size() != static_cast<std::size_t>(lattice_.columns())) {
      throw std::logic_error("a sampler was handed a load of another lattice");
    }
    check_load(load);
  }

  void check_load(std::span<const double> load) const {
    for (std::size_t i = 0; i < load.size(); ++i) {
      if (load[i] > 0 && std::isfinite(load[i])) continue;
      if (load[i] == 0 && takes_zero_) continue;
      if (load[i] == 0) {
        throw InputError(
            "there is no load on top bead {}: while the friction angle is below {} degrees (mu < {}) "
            "a force next to an unloaded bead can only go straight on; load every top bead",
            i, lattice_.geometry().angle,
            lattice_.geometry().angle == usual_angle ? "1/sqrt(3)" : significant(lattice_.geometry().tangent, 4));
      }
      throw InputError(
          "the load {} on top bead {} is not a positive finite number: a top bead can only be pressed "
          "down; give every top bead such a load",
          load[i], i);
    }
    if (std::all_of(load.begin(), load.end(), [](double force) { return force == 0; })) {
      throw InputError("no top bead carries a load, so that there is no force in the pile; load at least one");
    }
  }

  std::unique_ptr<Sampler> inner_;
  bool takes_zero_;  ///< unloaded beads can carry their neighbours' force
};

}  // namespace

void begin_pile(const SamplerSpec& spec, Law law, std::uint64_t sample, std::span<const double> load, Pile& pile) {
  pile.mu = spec.mu;
  pile.law = name_of(law);
  pile.seed = spec.seed;
  pile.sample = sample;
  pile.load.assign(load.begin(), load.end());
  pile.load_line = load_line(spec);
  pile.bead_weight = spec.bead_weight;
}

void Sampler::draw_alone(std::uint64_t sample, const std::span<const double>& load,
                         std::optional<SamplingFailure>& failure) {
  if (drawn_alone_ == alone_.size()) alone_.emplace_back(lattice_);
  Pile& pile = alone_[drawn_alone_++];
  failure = draw(sample, load, pile);
  groups_.push_back(group_of(pile, load));
}

std::span<const PileGroup> Sampler::draw_groups(std::span<const std::uint64_t> samples,
                                                std::span<const std::span<const double>> loads,
                                                std::span<std::optional<SamplingFailure>> failures) {
  groups_.clear();
  drawn_alone_ = 0;
  for (std::size_t k = 0; k < loads.size(); ++k) draw_alone(samples[k], loads[k], failures[k]);
  return groups_;
}

std::size_t piles_at_once(const SamplerSpec& spec, const Lattice& lattice, const KeptLayers* kept) {
  // Where few beads fail, two groups at once hide less waiting than they cost memory traffic in wide piles.
  constexpr double least_mu_for_two = 0.15;
  if (!spec.model.is_beads()) return group_lanes;
  if (!drawn_side_by_side(spec) || !(spec.mu > 0) || !GranusolveGroup::fits(lattice, kept)) return 1;
  return spec.mu >= least_mu_for_two ? 2 * group_lanes : group_lanes;
}

double drawing_memory(const SamplerSpec& spec, const Lattice& lattice, const KeptLayers* kept) {
  if (spec.model.name == ModelName::diluted_beads) return DilutedBeadsSampler::memory(lattice);
  if (!spec.model.is_beads()) return RowModelSampler::memory(lattice, kept);
  const double pile = 32, solver = 68;  // bytes per bead, the latter for the law that needs most
  const double granusolve = 15;         // of a pile by itself, such as the groups have evicted
  const auto piles = static_cast<double>(piles_at_once(spec, lattice, kept));
  if (piles > 1) {
    return piles / static_cast<double>(group_lanes) * GranusolveGroup::memory(lattice, kept) +
           (pile + granusolve) * static_cast<double>(lattice.beads());
  }
  return (pile + solver) * static_cast<double>(lattice.beads());
}

std::unique_ptr<Sampler> make_sampler(const SamplerSpec& spec, const Lattice& lattice) {
  validate(spec);
  if (!spec.model.is_beads()) {
    refuse(find_problem(spec.model, {lattice.columns(), lattice.layers()}));
    if (spec.model.name == ModelName::diluted_beads) {
      return std::make_unique<CheckedSampler>(std::make_unique<DilutedBeadsSampler>(spec, lattice), lattice, false);
    }
    return std::make_unique<CheckedSampler>(std::make_unique<RowModelSampler>(spec, lattice), lattice, true);
  }
  const FrictionCone cone(spec.mu, lattice.geometry());
  std::unique_ptr<Sampler> sampler;
  if (cone.mu() == 0) {
    sampler = std::make_unique<FrictionlessSampler>(spec, lattice);
  } else if (spec.law == Law::granusolve) {
    sampler = std::make_unique<GranusolveSampler>(spec, lattice);
  } else if (spec.law == Law::eloy_clement) {
    sampler = std::make_unique<EloyClementSampler>(spec, lattice);
  } else if (spec.law == Law::rejection) {
    sampler = std::make_unique<RejectionSampler>(spec, lattice);
  } else {
    sampler = std::make_unique<PolytopeSampler>(spec, lattice);
  }
  // t- <= 0: a contact may lean outwards.
  return std::make_unique<CheckedSampler>(std::move(sampler), lattice, cone.mu() > 0 && cone.t_minus() <= 0);
}

}  // namespace granuscope
