#include "analysis/synthetic_ensemble.h"

#include <cmath>
#include <random>

#include "analysis/double_gaussian.h"
#include "model/lattice.h"

namespace granuscope {

MeasuredEnsemble synthetic_ensemble(const KnownTransport& known, const SyntheticNoise& noise, int columns,
                                    const std::vector<int>& layers, int blocks, std::uint64_t samples_per_block) {
  const auto response_of = [&](int layer) {
    const Lattice lattice({columns, layer + 1});
    const double z = Lattice::depth(layer);
    std::vector<double> x;
    for (int i = 0; i < columns; ++i) x.push_back(lattice.x(layer, i));
    const auto grown = [z](double power) { return 80 * std::pow(z / 80, power); };
    const DoubleGaussian shape{known.position_offset + known.c * grown(known.position_power),
                               std::sqrt(known.width_offset + known.D * grown(known.width_power))};
    std::vector<double> response = evaluate(shape, x, columns);
    const std::vector<double> middle = evaluate({0, shape.width}, x, columns);
    for (std::size_t i = 0; i < response.size(); ++i) response[i] += known.in_the_middle * (middle[i] - response[i]);
    return response;
  };
  return synthetic_ensemble(response_of, known.alpha_thrust, noise, columns, layers, blocks, samples_per_block);
}

MeasuredEnsemble synthetic_ensemble(const std::function<std::vector<double>(int)>& response_of, double alpha_thrust,
                                    const SyntheticNoise& noise, int columns, const std::vector<int>& layers,
                                    int blocks, std::uint64_t samples_per_block) {
  std::mt19937_64 generator(noise.seed);
  std::normal_distribution<double> normal;
  MeasuredEnsemble ensemble;
  ensemble.spec.sampler.mu = 0.3;
  BlockSums& sums = ensemble.record.sums;
  sums.layers = layers;
  sums.count.assign(static_cast<std::size_t>(blocks), samples_per_block);
  const std::size_t rows = static_cast<std::size_t>(blocks) * layers.size();
  const auto width = static_cast<std::size_t>(columns);
  sums.quantities["weight"] = {columns, std::vector<double>(rows * width), std::vector<double>(rows * width)};
  sums.quantities["thrust"] = {1, std::vector<double>(rows), std::vector<double>(rows)};
  const auto samples = static_cast<double>(samples_per_block);
  const double from_above = noise.depth_correlation, fresh = std::sqrt(1 - from_above * from_above);
  std::vector<std::vector<double>> exchanges(sums.count.size(), std::vector<double>(width));
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const std::vector<double> response = response_of(layers[l]);
    for (std::size_t b = 0; b < sums.count.size(); ++b) {
      const std::size_t row = b * layers.size() + l;
      std::vector<double>& exchange = exchanges[b];
      for (double& e : exchange) e = (l == 0 ? 0 : from_above * e) + (l == 0 ? 1 : fresh) * normal(generator);
      for (std::size_t i = 0; i < width; ++i) {
        const double fluctuation = (exchange[i] - exchange[(i + 1) % width]) * noise.per_sample / std::sqrt(2.0);
        sums.quantities["weight"].sum[row * width + i] = samples * (1 + response[i]) + std::sqrt(samples) * fluctuation;
      }
      sums.quantities["thrust"].sum[row] =
          samples * alpha_thrust + std::sqrt(samples) * 0.01 * noise.per_sample * normal(generator);
    }
  }
  return ensemble;
}

}  // namespace granuscope
