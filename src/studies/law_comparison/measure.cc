#include "measure.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/effective_samples.h"
#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"
#include "analysis/speed_from_thrust.h"
#include "analysis/transport.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// At mu = 0.3 the peaks of granusolve are half a bead wide there, and narrower above.
constexpr int first_response_layer = 4;

/// What was drawn, and how its chains ran; the mean over the chains, all of which run alike.
template <class Measured>
void set_law(const EnsembleSpec& spec, const SamplerCounts& counts, Measured& result) {
  const bool chain = spec.sampler.law == Law::polytope;
  const auto per_chain = [&](std::uint64_t sweeps) {
    return chain && counts.chains > 0 ? static_cast<double>(sweeps) / static_cast<double>(counts.chains) : nan;
  };
  result.spec = spec;
  result.burn_in = per_chain(counts.burn_in);
  result.thinning = per_chain(counts.thinning);
}

}  // namespace

LawOnPiles measure_law(const MeasuredEnsemble& ensemble) {
  const auto& [spec, record] = ensemble;
  const BlockSums& sums = record.sums;
  const SamplerCounts& counts = record.counts;
  const auto per_bead = [&](std::uint64_t count) {
    return counts.beads == 0 ? nan : static_cast<double>(count) / static_cast<double>(counts.beads);
  };
  LawOnPiles result;
  set_law(spec, counts, result);
  result.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  result.failed = record.failed.size();
  result.effective_samples = effective_samples(sums);
  result.draws_per_bead = per_bead(counts.uniforms);
  result.pair_per_bead = per_bead(counts.repaired_by_pair);
  result.arc_per_bead = per_bead(counts.repaired_by_arc + counts.repaired_by_ring);
  result.backtracked_per_bead = per_bead(counts.backtracked);
  const int layers = spec.lattice.layers;
  result.first_layer = layers / 3;
  result.last_layer = std::max(result.first_layer, 2 * layers / 3 - 1);
  std::vector<Replicated> thrusts, variances;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int layer = sums.layers[row];
    const Replicated thrust = block_mean(sums, "thrust", row), variance = block_mean(sums, "weight_variance", row);
    result.depths.push_back({layer, Lattice::depth(layer), estimate(thrust), estimate(variance)});
    if (layer < result.first_layer || layer > result.last_layer) continue;
    thrusts.push_back(thrust);
    variances.push_back(variance);
  }
  const Replicated alpha = mean_of(thrusts);
  result.alpha_thrust = estimate(alpha, "no pile was completed");
  result.c_thrust = estimate(transform(speed_from_thrust, alpha), "the mean thrust ratio is unknown");
  result.weight_variance = estimate(mean_of(variances), "no pile was completed");
  return result;
}

FitSpec law_response_fit(const LatticeSpec& lattice) {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = first_response_layer;
  fit.last_layer = lattice.layers - bottom_margin - 1;
  fit.layer_step = 1;
  return fit;
}

LawResponse measure_law_response(const MeasuredEnsemble& ensemble, int threads) {
  const FitSpec fit = law_response_fit(ensemble.spec.lattice);
  const Transport transport = measure_transport(ensemble, fit, {}, threads).transport;
  LawResponse result;
  set_law(ensemble.spec, ensemble.record.counts, result);
  result.samples = transport.samples;
  result.failed = ensemble.record.failed.size();
  result.effective_samples = effective_samples(ensemble.record.sums);
  result.first_layer = transport.window_layers[0];
  result.last_layer = transport.window_layers[1];
  result.c = transport.c;
  result.D = transport.D;
  return result;
}

}  // namespace granuscope
