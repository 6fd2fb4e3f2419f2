#pragma once
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "analysis/mean_response.h"
#include "model/lattice.h"

namespace granuscope::test {

/// Two fields of which each Fourier mode is a stationary chain: it turns by the angle c k dz a layer, decays as the
/// diffusion D has it, and is stirred by what restores its variance. The response is then cos(c k z) exp(-k^2 D z/2)
/// exactly. As balance has it, dw/dz = -dH/dx. `H_scale`: the size of the second field. `slip`: a share of the first
/// field's variance that each layer has for itself, as the forces on single beads do.
struct LinearModel {
  static constexpr int columns = 240, modes = 60;
  static constexpr double c = 0.55, D = 0.08;
  double H_scale = 0.4, slip = 0;
};

/// Sums as the estimator leaves them.
inline MeasuredEnsemble linear_ensemble(const LinearModel& model, std::uint64_t seed, int reference,
                                        const std::vector<int>& lags, int blocks, int piles) {
  using Complex = std::complex<double>;
  constexpr int bases = 20, step = 6, columns = LinearModel::columns;
  constexpr double c = LinearModel::c, D = LinearModel::D;
  const double dz = Lattice::depth(1) - Lattice::depth(0);
  MeasuredEnsemble ensemble;
  ensemble.spec.response.estimator = EstimatorName::fluctuation;
  ensemble.spec.sampler.mu = 0.3;
  ensemble.spec.lattice.columns = columns;
  BlockSums& sums = ensemble.record.sums;
  sums.layers = {0};
  sums.layers.insert(sums.layers.end(), lags.begin(), lags.end());
  const std::size_t rows = sums.layers.size(), width = 2 * columns;
  const auto b = static_cast<std::size_t>(blocks);
  sums.count.assign(b, static_cast<std::uint64_t>(piles));
  sums.quantities["propagation"] = {2 * columns, std::vector<double>(b * rows * width),
                                    std::vector<double>(b * rows * width)};
  sums.quantities["thrust"] = {1, std::vector<double>(b * rows), std::vector<double>(b * rows)};
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> gauss(0, std::sqrt(0.5));
  const auto chance = [&] { return Complex(gauss(generator), gauss(generator)); };
  const auto layers = static_cast<std::size_t>(step * (bases - 1) + reference + lags.back() + 1);
  std::vector<Complex> w(layers), H(layers);
  for (std::size_t block = 0; block < b; ++block) {
    for (std::size_t row = 0; row < rows; ++row) {
      sums.quantities["thrust"].sum[block * rows + row] = piles * (0.93 + 1e-5 * gauss(generator));
    }
    for (int pile = 0; pile < piles; ++pile) {
      for (int m = 1; m <= LinearModel::modes; ++m) {
        const double k = 2 * std::numbers::pi * m / columns;
        const double kept = std::exp(-D * k * k * dz / 2), stirred = std::sqrt(1 - kept * kept);
        const double cosine = kept * std::cos(c * k * dz), sine = kept * std::sin(c * k * dz);
        w[0] = chance();
        H[0] = chance();
        for (std::size_t n = 0; n + 1 < layers; ++n) {
          w[n + 1] = cosine * w[n] - Complex(0, sine) * H[n] + stirred * chance();
          H[n + 1] = cosine * H[n] - Complex(0, sine) * w[n] + stirred * chance();
        }
        for (Complex& one : w) one += std::sqrt(model.slip) * chance();
        for (std::size_t row = 0; row < rows; ++row) {
          double* const part =
              &sums.quantities["propagation"].sum[(block * rows + row) * width + 4 * (static_cast<std::size_t>(m) - 1)];
          for (int base = 0; base < bases; ++base) {
            const auto at = static_cast<std::size_t>(step * base);
            const auto below = at + static_cast<std::size_t>(reference + sums.layers[row]);
            part[0] += std::real(w[below] * std::conj(w[at])) / bases;
            part[1] += model.H_scale * model.H_scale * std::real(H[below] * std::conj(H[at])) / bases;
            part[2] += model.H_scale * std::imag(w[below] * std::conj(H[at])) / bases;
            part[3] += model.H_scale * std::imag(H[below] * std::conj(w[at])) / bases;
          }
        }
      }
    }
  }
  return ensemble;
}

}  // namespace granuscope::test
