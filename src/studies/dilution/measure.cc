#include "measure.h"

#include <cmath>
#include <numeric>

#include "analysis/transport.h"
#include "ensemble/parallel.h"
#include "sampling/diluted_beads.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

std::vector<double> even_load(const Lattice& lattice) {
  return std::vector<double>(static_cast<std::size_t>(lattice.columns()), 1.0);
}

}  // namespace

// The error of a count that may be none or all: of half a pile more in one more (Jeffreys' prior).
Estimate SolvableShare::share_of(std::uint64_t count) const {
  const auto all = static_cast<double>(piles), some = static_cast<double>(count);
  const double p = (some + 0.5) / (all + 1);
  return {.value = some / all, .standard_error = std::sqrt(p * (1 - p) / all), .reason = ""};
}

std::vector<SolvableShare> measure_solvable_shares(const std::vector<double>& mu, const std::vector<int>& sizes,
                                                   const std::vector<double>& shares, std::uint64_t piles,
                                                   std::uint64_t seed, int threads) {
  std::vector<SolvableShare> all;
  for (const double friction : mu) {
    for (const int size : sizes) {
      for (const double share : shares) {
        SolvableShare& one = all.emplace_back();
        one.mu = friction;
        one.size = size;
        one.share = share;
        one.piles = piles;
        one.no_idle_bead = std::pow(1 - share * share, size * (size - undiluted_layers));
      }
    }
  }
  for_each_index(all.size(), threads, [&](std::size_t k) {
    SolvableShare& one = all[k];
    const Lattice lattice({one.size, one.size});
    const ContactBalances balances(one.mu, lattice);
    for (std::uint64_t pile = 0; pile < piles; ++pile) {
      throw_if_interrupted();
      const OpenedContacts opened = open_at_random(lattice, one.share, RandomKey(seed, pile));
      const Solvability found = find_largest_slack(balances, opened, even_load(lattice)).solvability;
      if (found == Solvability::inside) ++one.inside;
      if (found == Solvability::edge) ++one.edge;
    }
  });
  return all;
}

std::vector<LargestShare> measure_largest_shares(const std::vector<double>& mu, const std::vector<int>& sizes,
                                                 double least_slack, std::uint64_t piles, std::uint64_t seed,
                                                 int threads) {
  std::vector<LargestShare> all;
  for (const double friction : mu) {
    for (const int size : sizes) all.push_back({friction, size, piles, {}});
  }
  std::vector<double> reached(all.size() * piles);
  for_each_index(reached.size(), threads, [&](std::size_t k) {
    const LargestShare& one = all[k / piles];
    const Lattice lattice({one.size, one.size});
    const ContactBalances balances(one.mu, lattice);
    const OpenedStepwise opened =
        open_while_solvable(balances, {even_load(lattice)}, 1, least_slack, RandomKey(seed, k % piles));
    reached[k] = static_cast<double>(opened.count) / (2.0 * one.size * (one.size - undiluted_layers));
  });
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double* first = reached.data() + k * piles;
    const auto count = static_cast<double>(piles);
    const double mean = std::accumulate(first, first + piles, 0.0) / count;
    double squares = 0;
    for (std::uint64_t pile = 0; pile < piles; ++pile) squares += (first[pile] - mean) * (first[pile] - mean);
    all[k].share = {.value = mean, .standard_error = std::sqrt(squares / (count * (count - 1))), .reason = ""};
  }
  return all;
}

DilutedResponse measure_diluted_response(const MeasuredEnsemble& ensemble, const FitSpec& fit, int threads) {
  const BlockSums& sums = ensemble.record.sums;
  DilutedResponse response;
  response.mu = ensemble.spec.sampler.mu;
  response.share = ensemble.spec.sampler.model.diluted_beads.share;
  response.columns = ensemble.spec.lattice.columns;
  response.layers = ensemble.spec.lattice.layers;
  response.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  response.failed = ensemble.record.failed.size();
  const Transport transport = measure_transport(ensemble, fit, {fit.last_layer}, threads).transport;
  response.c = transport.c;
  response.D = transport.D;
  if (!transport.profiles.empty()) response.profile = transport.profiles.back();
  for (const DepthFit& depth : transport.depths) {
    if (depth.layer != fit.last_layer) continue;
    response.z = depth.z;
    response.position = depth.peak_position;
    response.width = depth.width;
    response.thrust_ratio = depth.thrust_ratio;
  }
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    if (sums.layers[row] != fit.last_layer) continue;
    response.fits = fit_response_shapes(layer_spectrum(sums, row, ensemble.spec.response.overload), response.z);
    const ResponseShape shape = best_shape(response.fits);
    const FittedResponseShape& best = response.fits[static_cast<std::size_t>(shape)];
    response.peaks = best.position > (shape == ResponseShape::two_gaussians ? best.width : 0) ? 2 : 1;
  }
  return response;
}

}  // namespace granuscope
