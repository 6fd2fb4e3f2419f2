#include "sampling/diluted_beads.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "model/equilibrium.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

constexpr std::uint64_t group_of_samples = 8;

/// The load with every difference from its mean reversed; empty where that would pull or leave a bead without load.
std::vector<double> opposite(std::span<const double> load) {
  const double mean = std::accumulate(load.begin(), load.end(), 0.0) / static_cast<double>(load.size());
  std::vector<double> reversed;
  for (const double force : load) {
    if (!(2 * mean - force > 0)) return {};
    reversed.push_back(2 * mean - force);
  }
  return reversed;
}

/// Loads between which rounding makes the difference.
bool alike(std::span<const double> a, std::span<const double> b) {
  constexpr double rounding = 1e-12;
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double one, double other) { return std::abs(one - other) <= rounding * one; });
}

}  // namespace

std::vector<RandomContact> contacts_in_random_order(const Lattice& lattice, RandomKey key) {
  std::vector<RandomContact> contacts;
  for (int layer = undiluted_layers; layer < lattice.layers(); ++layer) {
    for (int i = 0; i < lattice.columns(); ++i) {
      const UniformPair numbers = key.attempt(layer, i, 1);
      contacts.push_back({numbers.first, lattice.index(layer, i)});
      contacts.push_back({numbers.second, lattice.beads() + lattice.index(layer, i)});
    }
  }
  std::sort(contacts.begin(), contacts.end(), [](const RandomContact& a, const RandomContact& b) {
    return a.number != b.number ? a.number < b.number : a.contact < b.contact;
  });
  return contacts;
}

OpenedContacts open_at_random(const Lattice& lattice, double share, RandomKey key) {
  OpenedContacts opened(2 * lattice.beads());
  for (const auto& [number, contact] : contacts_in_random_order(lattice, key)) opened[contact] = number < share;
  return opened;
}

OpenedStepwise open_while_solvable(const ContactBalances& balances, const std::vector<std::vector<double>>& loads,
                                   double share, double least_slack, RandomKey key) {
  const std::size_t beads = balances.lattice().beads();
  const std::vector<RandomContact> candidates = contacts_in_random_order(balances.lattice(), key);
  const auto wanted = static_cast<std::size_t>(std::round(share * static_cast<double>(candidates.size())));
  OpenedStepwise result;
  result.opened.assign(balances.contacts(), 0);
  if (wanted == 0) {
    result.complete = true;
    return result;
  }
  std::vector<StepwiseOpening> piles;
  piles.reserve(loads.size());
  for (const std::vector<double>& load : loads) piles.emplace_back(balances, load, least_slack);
  const auto all_solvable = [&] {
    return std::all_of(piles.begin(), piles.end(), [](StepwiseOpening& pile) { return pile.solvable(); });
  };
  if (!all_solvable()) return result;
  for (const RandomContact& candidate : candidates) {
    const std::size_t contact = candidate.contact;
    // Without any lower contact a bead can bear nothing.
    if (result.opened[contact < beads ? contact + beads : contact - beads] != 0) continue;
    throw_if_interrupted();
    for (StepwiseOpening& pile : piles) pile.open(contact);
    if (!all_solvable()) {
      for (StepwiseOpening& pile : piles) pile.close(contact);
      continue;
    }
    result.opened[contact] = 1;
    result.complete = ++result.count == wanted;
    if (result.complete) break;
  }
  return result;
}

void FlatWalk::move(const NullDirection& direction, double uniform) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Interval reach{-infinity, infinity};
  const auto bound = [&reach](double slack, double change) {
    if (change > 0) reach.low = std::max(reach.low, -slack / change);
    if (change < 0) reach.high = std::min(reach.high, -slack / change);
  };
  for (const SlackChange& change : direction) {
    bound(slacks_.low[change.contact], change.low);
    bound(slacks_.high[change.contact], change.high);
  }
  if (!(reach.low < reach.high)) return;  // a corner, or one that rounding has made
  const double t = point_at(reach, uniform);
  for (const SlackChange& change : direction) {
    slacks_.low[change.contact] += t * change.low;
    slacks_.high[change.contact] += t * change.high;
  }
}

DilutedBeadsSampler::DilutedBeadsSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice), spec_(spec), balances_(spec.mu, lattice) {}

double DilutedBeadsSampler::memory(const Lattice& lattice) {
  // The balances of the whole pile as a full matrix, solved once for each walk.
  const auto beads = static_cast<double>(lattice.beads());
  return 8 * 12 * beads * beads;
}

std::optional<SamplingFailure> DilutedBeadsSampler::draw(std::uint64_t sample, std::span<const double> load,
                                                         Pile& pile) {
  const std::uint64_t group = sample / group_of_samples, wanted = sample % group_of_samples;
  const bool same_load = std::equal(load.begin(), load.end(), load_.begin(), load_.end());
  if (!same_load || walk_group_ != group || in_group_ > wanted) {
    if (!begin_walk(group, load)) return SamplingFailure{0};
  }
  for (; in_group_ < wanted; ++in_group_) run(thinning_sweeps());
  balances_.store(walk_->slacks(), pile);
  pile.load.assign(load.begin(), load.end());
  pile.load_line = {};
  pile.law = name_of(ModelName::diluted_beads);
  pile.seed = spec_.seed;
  pile.sample = sample;
  ++counts_.tries;
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

bool DilutedBeadsSampler::begin_walk(std::uint64_t group, std::span<const double> load) {
  walk_group_.reset();
  key_ = RandomKey(spec_.seed, group * group_of_samples);
  const bool known = opened_group_ == group && std::any_of(opened_loads_.begin(), opened_loads_.end(),
                                                           [&](const auto& one) { return alike(one, load); });
  if (!known) {
    opened_loads_.assign(1, {load.begin(), load.end()});
    std::vector<double> reversed = opposite(load);
    // Both in one order, whichever was asked for, so that the programmes meet the same rounding.
    if (!reversed.empty() && !alike(reversed, load)) opened_loads_.push_back(std::move(reversed));
    std::sort(opened_loads_.begin(), opened_loads_.end());
    opened_ = open_while_solvable(balances_, opened_loads_, spec_.model.diluted_beads.share,
                                  spec_.model.diluted_beads.least_slack, key_);
    opened_group_ = group;
  }
  if (!opened_.complete) return false;
  LargestSlack start = find_largest_slack(balances_, opened_.opened, load);
  if (start.solvability != Solvability::inside) return false;
  if (directions_of_ != opened_.opened) {
    directions_ = find_null_directions(balances_, opened_.opened);
    directions_of_ = opened_.opened;
  }
  walk_.emplace(std::move(start.slacks), directions_);
  ++counts_.chains;
  counts_.burn_in += burn_in_sweeps();
  counts_.thinning += thinning_sweeps();
  load_.assign(load.begin(), load.end());
  sweeps_ = 0;
  run(burn_in_sweeps());
  walk_group_ = group;
  in_group_ = 0;
  return true;
}

void DilutedBeadsSampler::run(std::uint64_t sweeps) {
  for (std::uint64_t k = 0; k < sweeps; ++k) {
    if (sweeps_ % 64 == 0) throw_if_interrupted();
    ++sweeps_;
    walk_->sweep(
        [this](std::size_t direction) { return key_.chain_move(0, static_cast<int>(direction), sweeps_).first; });
  }
  const std::uint64_t moves = sweeps * walk_->directions();
  counts_.moves += moves;
  counts_.uniforms += moves;
}

}  // namespace granuscope
