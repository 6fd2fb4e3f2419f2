#include "ensemble/multiplexed_estimator.h"

#include <algorithm>

#include "sampling/random_key.h"

namespace granuscope {

std::vector<QuantityShape> MultiplexedEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerNumbers::quantities();
  if (spec.record_profiles) all.push_back({"correlation", spec.lattice.columns});
  return all;
}

MultiplexedEstimator::MultiplexedEstimator(const EnsembleSpec& spec, Sampler& sampler, BlockSums& sums, int block)
    : seed_(spec.sampler.seed),
      epsilon_(spec.epsilon),
      columns_(static_cast<std::size_t>(spec.lattice.columns)),
      signs_(piles_at_once(spec.sampler, Lattice(spec.lattice)), std::vector<double>(columns_)),
      loads_(signs_),
      sign_spectrum_(columns_),
      spectrum_(columns_),
      fourier_(columns_),
      sampler_(sampler),
      layers_(sums.layers),
      numbers_(sums, block),
      profiles_(spec.record_profiles),
      correlation_(profiles_ ? BlockSlice(sums, "correlation", block) : BlockSlice()) {}

void MultiplexedEstimator::choose_signs(std::uint64_t sample, std::size_t k) {
  const RandomKey key(seed_, sample);
  for (std::size_t i = 0; i < columns_; ++i) {
    signs_[k][i] = key.load_bit(static_cast<int>(i)) ? 1 : -1;
    loads_[k][i] = 1 + epsilon_ * signs_[k][i];
  }
}

std::optional<SamplingFailure> MultiplexedEstimator::measure(std::uint64_t sample) {
  std::optional<SamplingFailure> failure;
  measure_samples({&sample, 1}, {&failure, 1});
  return failure;
}

void MultiplexedEstimator::measure_samples(std::span<const std::uint64_t> samples,
                                           std::span<std::optional<SamplingFailure>> failures) {
  const std::vector<std::span<const double>> loads(loads_.begin(), loads_.end());
  for (std::size_t done = 0; done < failures.size(); done += loads.size()) {
    const std::size_t count = std::min(loads.size(), failures.size() - done);
    for (std::size_t k = 0; k < count; ++k) choose_signs(samples[done + k], k);
    std::size_t first = 0;  // pile of the group, among those drawn at once
    for (const PileGroup& group :
         sampler_.draw_groups(samples.subspan(done, count), {loads.data(), count}, failures.subspan(done, count))) {
      const auto failed = failures.subspan(done + first, group.piles);
      assert_identities(group, failed);
      numbers_.add(group, failed);
      for (std::size_t k = 0; profiles_ && k < group.piles; ++k) {
        if (failed[k]) continue;
        sign_spectrum_ = signs_[first + k];
        fourier_.transform(sign_spectrum_);
        add_correlation(group, k);
      }
      first += group.piles;
    }
  }
}

void MultiplexedEstimator::add_correlation(const PileGroup& group, std::size_t k) {
  const std::size_t columns = columns_;
  const double scale = 1 / (static_cast<double>(columns) * epsilon_);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = group.row(layers_[l]) + k;
    for (std::size_t i = 0; i < columns; ++i) {
      spectrum_[i] = group.V_R[row + i * group.stride] + group.V_L[row + i * group.stride] - 1;
    }
    fourier_.transform(spectrum_);
    correlation_.add(l, 0, scale * sign_spectrum_[0] * spectrum_[0]);
    for (std::size_t re = 1, im = 2; im < columns; re += 2, im += 2) {
      const double a = sign_spectrum_[re], b = sign_spectrum_[im], c = spectrum_[re], d = spectrum_[im];
      correlation_.add(l, re, scale * (a * c + b * d));
      correlation_.add(l, im, scale * (a * d - b * c));
    }
    if (columns % 2 == 0) {
      correlation_.add(l, columns - 1, scale * sign_spectrum_[columns - 1] * spectrum_[columns - 1]);
    }
  }
}

}  // namespace granuscope
