#include "analysis/stress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/audit.h"
#include "model/friction_cone.h"
#include "sampling/portable_power.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

using Load = std::vector<double>;

Load even_load(int columns) { return Load(static_cast<std::size_t>(columns), 1.0); }

Load overloaded(int columns) {
  Load load = even_load(columns);
  load[load.size() / 2] = 2;
  return load;
}

Load half_unloaded(int columns) {
  Load load = even_load(columns);
  std::fill(load.begin(), load.begin() + columns / 2, 0.0);
  return load;
}

/// 1e-5 to 1e5 in random order, both among them.
Load ten_orders(int columns, std::uint64_t seed) {
  const RandomKey key(seed, 0);
  Load load;
  for (int i = 0; i < columns; ++i) load.push_back(1e-5 * portable_power(1e10, key.attempt(0, i, 1).first));
  load[0] = 1e5;
  load[1] = 1e-5;
  return load;
}

/// Ranges of layers that double in length.
std::vector<ResidualAtDepth> by_depth(const std::vector<LayerResidual>& layers) {
  std::vector<ResidualAtDepth> depths;
  const int count = static_cast<int>(layers.size());
  for (int first = 0, next = 1; first < count; first = next, next = std::min(2 * next, count)) {
    ResidualAtDepth range{first, next - 1, 0};
    for (int layer = first; layer < next; ++layer) {
      const LayerResidual& one = layers[static_cast<std::size_t>(layer)];
      range.residual = std::max({range.residual, one.balance, one.cone});
    }
    depths.push_back(range);
  }
  return depths;
}

StressTrial attempt(double mu, LatticeSpec size, const std::string& name, const Load& load, std::uint64_t seed) {
  throw_if_interrupted();
  StressTrial trial;
  trial.mu = mu;
  trial.columns = size.columns;
  trial.layers = size.layers;
  trial.load = name;
  const Lattice lattice(size);
  SamplerSpec spec;
  spec.mu = mu;
  spec.seed = seed;
  try {
    const auto sampler = make_sampler(spec, lattice);
    Pile pile(lattice);
    if (const auto failure = sampler->draw(0, load, pile)) {
      trial.outcome = "stuck";
      trial.reason =
          fmt::format("the effort of {} solutions per bead ran out at layer {}", spec.effort, failure->layer);
      return trial;
    }
    trial.depths = by_depth(audit_layers(pile));
    for (const ResidualAtDepth& range : trial.depths) trial.residual = std::max(trial.residual, range.residual);
    const SamplerCounts& counts = sampler->counts();
    trial.rounded_per_bead = static_cast<double>(counts.rounded) / static_cast<double>(counts.beads);
    trial.outcome = "solved";
  } catch (const InputError& refused) {
    trial.outcome = "refused";
    trial.reason = refused.what();
  }
  return trial;
}

}  // namespace

std::vector<double> stress_friction() {
  return {1e-9, 1e-3, std::nextafter(tan30, 0.0), tan30, std::nextafter(tan30, 1.0), 1.7, 1.73};
}

std::vector<StressTrial> run_stress(const StressSpec& spec, std::uint64_t seed) {
  std::vector<StressTrial> trials;
  if (spec.layers <= 0) return trials;
  for (const double mu : stress_friction()) {
    trials.push_back(attempt(mu, {spec.columns, spec.layers}, "one bead 2, others 1", overloaded(spec.columns), seed));
    trials.back().deep = true;
  }
  const LatticeSpec narrow{4, narrow_stress_layers}, uneven{spec.columns, uneven_stress_layers};
  for (const double mu : stress_friction()) {
    trials.push_back(attempt(mu, narrow, "one bead 2, others 1", overloaded(narrow.columns), seed));
    trials.push_back(attempt(mu, uneven, "ten orders of magnitude", ten_orders(uneven.columns, seed), seed));
    trials.push_back(attempt(mu, uneven, "half of the beads unloaded", half_unloaded(uneven.columns), seed));
  }
  return trials;
}

}  // namespace granuscope
