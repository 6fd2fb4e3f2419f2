#include "sampling/granusolve.h"

#include <algorithm>

#include "sampling/granusolve_group.h"
#include "sampling/layer_kernels.h"
#include "support/progress.h"

namespace granuscope {

GranusolveArrays GranusolveMemory::arrays(Pile& pile) {
  const std::size_t beads = pile.lattice.beads(), columns = static_cast<std::size_t>(pile.lattice.columns());
  H_.resize(beads);
  first_uniform_.resize(columns + uniform_padding);
  failing_.resize((columns + 63) / 64);
  attempts_.resize(beads);
  unsolved_.resize(beads);
  rule_.resize(beads);
  backtracks_.resize(beads);
  return {.V_R = pile.V_R.data(),
          .V_L = pile.V_L.data(),
          .H_R = pile.H_R.data(),
          .H_L = pile.H_L.data(),
          .H = H_.data(),
          .attempts = attempts_.data(),
          .unsolved = unsolved_.data(),
          .rule = rule_.data(),
          .backtracks = backtracks_.data(),
          .first_uniform = first_uniform_.data(),
          .failing = failing_.data()};
}

std::array<std::uint64_t, granusolve_rules> GranusolveMemory::beads_by() const {
  std::array<std::uint64_t, granusolve_rules> beads_by{};
  for (std::size_t bead = 0; bead < rule_.size(); ++bead) {
    ++beads_by[backtracks_[bead] != 0 ? static_cast<std::size_t>(GranusolveRule::backtrack) : rule_[bead]];
  }
  return beads_by;
}

GranusolveSampler::GranusolveSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice), spec_(spec), solver_(spec, lattice) {}

GranusolveSampler::~GranusolveSampler() = default;

std::optional<SamplingFailure> GranusolveSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  return solve_pile(sample, load, nullptr, pile);
}

std::optional<SamplingFailure> GranusolveSampler::draw_again(std::uint64_t sample, std::span<const double> load,
                                                             const Pile& first, Pile& pile) {
  return solve_pile(sample, load, &first, pile);
}

std::optional<SamplingFailure> GranusolveSampler::solve_pile(std::uint64_t sample, std::span<const double> load,
                                                             const Pile* first, Pile& pile) {
  pile.mu = spec_.mu;
  pile.law = name_of(Law::granusolve);
  pile.seed = spec_.seed;
  pile.sample = sample;
  pile.load.assign(load.begin(), load.end());
  pile.load_line = load_line(spec_);
  pile.bead_weight = spec_.bead_weight;
  solver_.use(memory_.arrays(pile));
  solver_.begin_pile(sample, load, first);
  SolveResult result = SolveResult::solved;
  int layer = 0;
  for (; layer < lattice_.layers() && result == SolveResult::solved; ++layer) {
    throw_if_interrupted();
    result = solver_.solve_layer(layer);
  }
  if (result == SolveResult::solved) solver_.count_pile(memory_.beads_by());
  counts_ += solver_.take_counts();
  if (result != SolveResult::solved) return SamplingFailure{layer - 1};
  return std::nullopt;
}

Pile& GranusolveSampler::spare_pile() {
  if (!spare_pile_) spare_pile_.emplace(lattice_);
  return *spare_pile_;
}

void GranusolveSampler::keep_layers(const KeptLayers& kept) {
  kept_layers_ = kept;
  groups_.clear();
  together_.clear();
}

std::span<const PileGroup> GranusolveSampler::draw_groups(std::span<const std::uint64_t> samples,
                                                          std::span<const std::span<const double>> loads,
                                                          std::span<std::optional<SamplingFailure>> failures) {
  groups_.clear();
  drawn_alone_ = 0;
  // Only eight samples from a multiple of eight on share the order of their layers, or the same sample under several
  // loads; a part of them is drawn with empty lanes, a single one by itself.
  struct Part {
    std::size_t begin, count;
    GranusolveGroup* together;
  };
  const KeptLayers* const kept = kept_layers_ ? &*kept_layers_ : nullptr;
  std::vector<Part> parts;
  std::vector<GranusolveGroup*> together;
  for (std::size_t done = 0; done < loads.size(); done += parts.back().count) {
    const std::uint64_t sample = samples[done];
    std::size_t count = 1;
    const bool same = done + 1 < samples.size() && samples[done + 1] == sample;
    while (done + count < samples.size() && samples[done + count] == (same ? sample : sample + count) &&
           (same ? count < group_lanes : (sample + count) % group_lanes != 0)) {
      ++count;
    }
    parts.push_back({done, count, nullptr});
    if (count < 2 || !drawn_side_by_side(spec_) || !GranusolveGroup::fits(lattice_, kept)) continue;
    if (together.size() == together_.size()) {
      together_.push_back(std::make_unique<GranusolveGroup>(spec_, lattice_, kept_layers_, *this));
    }
    parts.back().together = together_[together.size()].get();
    parts.back().together->prepare(sample, same, loads.subspan(done, count), failures.subspan(done, count));
    together.push_back(parts.back().together);
  }
  for (std::size_t g = 0; g < together.size(); g += 2) {
    if (g + 1 < together.size()) {
      GranusolveGroup::draw(*together[g], *together[g + 1]);
    } else {
      together[g]->draw();
    }
  }
  for (const Part& part : parts) {
    if (part.together != nullptr) {
      groups_.push_back(part.together->piles());
      counts_ += part.together->take_counts();
    } else {
      for (std::size_t k = part.begin; k < part.begin + part.count; ++k) {
        draw_alone(samples[k], loads[k], failures[k]);
      }
    }
  }
  return groups_;
}

}  // namespace granuscope
