#include "sampling/pile_group.h"

#include <x86intrin.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "sampling/layer_kernels.h"
#include "sampling/sampler.h"

#if defined(__x86_64__)
#endif

namespace granuscope {
namespace {

using Lanes = std::array<double, group_lanes>;

double total(std::span<const double> load) { return std::accumulate(load.begin(), load.end(), 0.0); }

/// Of a row whose entries all belong to one pile: the eight running values together, in entry 0.
void gather(RowFacts& facts) {
  const auto largest = [](Lanes& lanes) { lanes[0] = *std::max_element(lanes.begin(), lanes.end()); };
  facts.weight_sum[0] = total(facts.weight_sum);
  facts.finite_sum[0] = total(facts.finite_sum);
  largest(facts.largest_weight);
  largest(facts.largest_H);
  largest(facts.largest_residual);
}

void require_forces(const PileGroup& group) {
  if (group.V_R == nullptr || std::ranges::find(group.kept, -1) != group.kept.end())
    throw std::logic_error("forces were to be read of a group that kept only what is measured");
}

}  // namespace

PileGroup group_of(const Pile& pile, const std::span<const double>& load) {
  return {.lattice = pile.lattice,
          .V_R = pile.V_R.data(),
          .V_L = pile.V_L.data(),
          .H_R = pile.H_R.data(),
          .H_L = pile.H_L.data(),
          .moments = {},
          .kept = {},
          .loads = {&load, 1},
          .load_line = pile.load_line,
          .bead_weight = pile.bead_weight,
          .residuals = {},
          .mu = pile.mu,
          .law = pile.law,
          .seed = pile.seed,
          .first_sample = pile.sample};
}

int PileGroup::place_of(int layer) const {
  const int place = kept.empty() ? layer : kept[static_cast<std::size_t>(layer)];
  if (place < 0) throw std::logic_error("a layer was to be measured that was not kept");
  return place;
}

LayerMoments PileGroup::moments_of(int layer) const {
  if (!moments.empty()) return moments[static_cast<std::size_t>(place_of(layer))];
  return measure_row(forces(layer), static_cast<std::size_t>(lattice.columns()), stride,
                     mean_weight(bead_weight, layer), nullptr);
}

void GroupIdentities::begin(const Lattice& lattice, std::size_t stride, std::span<const std::span<const double>> loads,
                            double bead_weight) {
  *this = {};
  lattice_ = lattice;
  stride_ = stride;
  piles_ = loads.size();
  bead_weight_ = bead_weight;
  for (std::size_t k = 0; k < piles_; ++k) loads_[k] = total(loads[k]);
}

void GroupIdentities::add_layer(const ForceRow& here, const ForceRow& above, const ForceRow& two_above) {
  RowFacts facts;
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  if (layer_ < 2) {
    check_weights(here.V_R, here.V_L, here.H_R, columns * stride_, facts);
  } else {
    // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
    const std::size_t first = layer_ % 2 == 0 ? 1 : 0, seam = layer_ % 2 == 0 ? 0 : columns - 1;
    const auto run = [&](std::size_t bead, std::size_t left, std::size_t right, std::size_t beads) {
      const std::size_t at = bead * stride_, l = left * stride_, r = right * stride_;
      check_beads(
          {here.V_R + at, here.V_L + at, here.H_R + at, two_above.V_R + at, two_above.V_L + at, above.H_R + l,
           above.H_L + l, above.H_R + r, above.H_L + r, 2 * bead_weight_, above.totals, lattice_.geometry().cotangent},
          beads * stride_, facts);
    };
    run(first, 0, 1, columns - 1);
    run(seam, columns - 1, 0, 1);
  }
  if (stride_ == 1) gather(facts);
  for (std::size_t k = 0; k < piles_; ++k) {
    const auto worse = [](double so_far, double residual) {
      return std::isfinite(residual) ? std::max(so_far, residual) : std::numeric_limits<double>::infinity();
    };
    IdentityResiduals& pile = worst_[k];
    const double total = loads_[k] + bead_weight_ * static_cast<double>(columns) * (layer_ + 1);
    pile.weight_sum = worse(pile.weight_sum, std::abs(facts.weight_sum[k] - total) / total);
    if (!std::isfinite(facts.finite_sum[k])) pile.wave_equation = std::numeric_limits<double>::infinity();
    if (layer_ >= 2) {
      const double largest = std::max({largest_above_[k], largest_H_[k], facts.largest_weight[k]});
      if (largest > 0) pile.wave_equation = worse(pile.wave_equation, facts.largest_residual[k] / largest);
    }
    // Of the two layers above the next one: weights of both, horizontal forces of the nearer.
    largest_above_[k] = largest_middle_[k];
    largest_middle_[k] = facts.largest_weight[k];
    largest_H_[k] = facts.largest_H[k];
  }
  ++layer_;
}

std::array<IdentityResiduals, group_lanes> identity_residuals(const PileGroup& group) {
  require_forces(group);
  GroupIdentities identities;
  identities.begin(group.lattice, group.stride, group.loads, group.bead_weight);
  const auto row = [&](int layer) { return group.forces(std::max(layer, 0)); };
  for (int layer = 0; layer < group.lattice.layers(); ++layer) {
    identities.add_layer(row(layer), row(layer - 1), row(layer - 2));
  }
  return identities.residuals();
}

void assert_identities(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures) {
  std::array<IdentityResiduals, group_lanes> found{};
  if (group.residuals.empty()) found = identity_residuals(group);
  for (std::size_t k = 0; k < group.piles; ++k) {
    const IdentityResiduals& residuals = group.residuals.empty() ? found[k] : group.residuals[k];
    if (!failures[k])
      assert_identities(residuals, group.law, group.mu, group.seed, group.first_sample + group.sample_step * k);
  }
}

namespace {

/// A split counts as kept within so many units in the last place of the forces that its interval is computed from: the
/// sampler's own rounding allowance (random_key.h), and as much again for the interval recomputed here.
constexpr double kept_ulps = 128;

struct BeadInterval {
  Interval interval;  ///< not empty
  double rounding;    ///< of its ends
};

BeadInterval interval_of(const FrictionCone& cone, const Pile& pile, int layer, int bead) {
  const Incoming in = incoming(pile, layer, bead);
  Interval interval = split_interval(cone, balance(cone, in), in.H);
  const double scale = std::max({std::abs(interval.low), std::abs(interval.high), in.V_UL + in.V_UR, std::abs(in.H)});
  if (interval.empty()) interval.low = interval.high = interval.low + (interval.high - interval.low) / 2;
  return {interval, kept_ulps * std::numeric_limits<double>::epsilon() * scale};
}

template <typename Use>
void for_each_bead(const Lattice& lattice, Use use) {
  for (int layer = 0; layer < lattice.layers(); ++layer) {
    for (int bead = 0; bead < lattice.columns(); ++bead) use(layer, bead, lattice.index(layer, bead));
  }
}

double number_of(const BeadInterval& bead, double H_R) {
  const double length = bead.interval.high - bead.interval.low;
  return length > 0 ? std::clamp((H_R - bead.interval.low) / length, 0.0, 1.0) : 0.5;
}

}  // namespace

void read_split_uniforms(const Pile& pile, std::vector<double>& numbers) {
  numbers.resize(pile.lattice.beads());
  const FrictionCone cone(pile.mu, pile.lattice.geometry());
  for_each_bead(pile.lattice, [&](int layer, int bead, std::size_t at) {
    numbers[at] = number_of(interval_of(cone, pile, layer, bead), pile.H_R[at]);
  });
}

void find_redrawn(const Pile& first, const Pile& again, std::vector<unsigned char>& redrawn) {
  redrawn.resize(first.lattice.beads());
  const FrictionCone cone(first.mu, first.lattice.geometry());
  for_each_bead(first.lattice, [&](int layer, int bead, std::size_t at) {
    const BeadInterval before = interval_of(cone, first, layer, bead), after = interval_of(cone, again, layer, bead);
    const double kept =
        kept_split(first, at, number_of(before, first.H_R[at]), {again.V_R[at], again.V_L[at]}, after.interval);
    redrawn[at] = std::abs(again.H_R[at] - kept) > after.rounding ? 1 : 0;
  });
}

namespace {

thread_local PhaseTimes* of_this_thread = nullptr;

/// A clock that is read as fast as the machine allows.
std::uint64_t ticks() {
#if defined(__x86_64__)
  return __rdtsc();
#else
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

}  // namespace

PhaseTimes::PhaseTimes() : outer_(of_this_thread) { of_this_thread = this; }
PhaseTimes::~PhaseTimes() { of_this_thread = outer_; }
PhaseTimes* PhaseTimes::current() { return of_this_thread; }
void PhaseTimes::begin() { last_ = ticks(); }

void PhaseTimes::end(Phase phase) {
  const std::uint64_t now = ticks();
  ticks_[static_cast<std::size_t>(phase)] += now - last_;
  last_ = now;
}

std::array<double, phases> PhaseTimes::shares() const {
  const auto all = static_cast<double>(std::accumulate(ticks_.begin(), ticks_.end(), std::uint64_t{0}));
  std::array<double, phases> shares{};
  for (std::size_t p = 0; p < phases && all > 0; ++p) shares[p] = static_cast<double>(ticks_[p]) / all;
  return shares;
}

}  // namespace granuscope
