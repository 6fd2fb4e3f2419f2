#include "ensemble/multiplexed_estimator.h"

#include "model/identities.h"
#include "sampling/random_key.h"

namespace granuscope {

std::vector<QuantityShape> MultiplexedEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerNumbers::quantities();
  if (spec.record_profiles) all.push_back({"correlation", spec.lattice.columns});
  return all;
}

MultiplexedEstimator::MultiplexedEstimator(const EnsembleSpec& spec, BlockSums& sums, int block)
    : seed_(spec.sampler.seed),
      epsilon_(spec.epsilon),
      signs_(static_cast<std::size_t>(spec.lattice.columns)),
      load_(signs_.size()),
      sign_spectrum_(signs_.size()),
      spectrum_(signs_.size()),
      fourier_(signs_.size()),
      sampler_(make_sampler(spec.sampler, Lattice(spec.lattice))),
      pile_(Lattice(spec.lattice)),
      layers_(sums.layers),
      numbers_(sums, block),
      profiles_(spec.record_profiles),
      correlation_(profiles_ ? BlockSlice(sums, "correlation", block) : BlockSlice()) {}

void MultiplexedEstimator::choose_signs(std::uint64_t sample) {
  const RandomKey key(seed_, sample);
  for (std::size_t i = 0; i < signs_.size(); ++i) {
    signs_[i] = key.load_bit(static_cast<int>(i)) ? 1 : -1;
    load_[i] = 1 + epsilon_ * signs_[i];
  }
  sign_spectrum_ = signs_;
  fourier_.transform(sign_spectrum_);
}

std::optional<SamplingFailure> MultiplexedEstimator::measure(std::uint64_t sample) {
  choose_signs(sample);
  if (const auto failure = sampler_->draw(sample, load_, pile_)) return failure;
  assert_identities(pile_);
  numbers_.add(pile_);
  if (profiles_) add_correlation();
  return std::nullopt;
}

void MultiplexedEstimator::add_correlation() {
  const std::size_t columns = signs_.size();
  const double scale = 1 / (static_cast<double>(columns) * epsilon_);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = pile_.lattice.index(layers_[l], 0);
    for (std::size_t i = 0; i < columns; ++i) spectrum_[i] = pile_.V_R[row + i] + pile_.V_L[row + i] - 1;
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
