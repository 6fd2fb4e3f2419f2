#include "ensemble/multiplexed_estimator.h"

#include <algorithm>

#include "ensemble/load_signs.h"
#include "model/identities.h"

namespace granuscope {

std::vector<QuantityShape> MultiplexedEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerNumbers::quantities();
  if (spec.record_profiles) all.push_back({"correlation", spec.lattice.columns});
  return all;
}

MultiplexedEstimator::MultiplexedEstimator(const EnsembleSpec& spec, BlockSums& sums, int block)
    : spec_(spec),
      columns_(static_cast<std::size_t>(spec.lattice.columns)),
      signs_(piles_at_once(spec.sampler, Lattice(spec.lattice)), std::vector<double>(columns_)),
      sign_spectrum_(columns_),
      spectrum_(columns_),
      fourier_(columns_),
      sampler_(make_sampler(spec.sampler, Lattice(spec.lattice))),
      layers_(sums.layers),
      numbers_(sums, block),
      profiles_(spec.record_profiles),
      correlation_(profiles_ ? BlockSlice(sums, "correlation", block) : BlockSlice()) {
  side_ = {sampler_.get(), signs_, std::vector<Pile>(signs_.size(), Pile(Lattice(spec.lattice)))};
  if (!spec.opposite) return;
  opposite_ = side_;
  if (spec.sampler.law != Law::polytope) return;
  chain_ = make_sampler(spec.sampler, Lattice(spec.lattice));
  opposite_.sampler = chain_.get();
}

void MultiplexedEstimator::choose_loads(std::uint64_t sample, std::size_t k) {
  const bool chain = spec_.sampler.law == Law::polytope;
  draw_signs(spec_.sampler.seed, chain ? sample - sample % group_size : sample, spec_.sign_run, signs_[k]);
  for (std::size_t i = 0; i < columns_; ++i) {
    side_.loads[k][i] = 1 + spec_.epsilon * signs_[k][i];
    if (spec_.opposite) opposite_.loads[k][i] = 1 - spec_.epsilon * signs_[k][i];
  }
}

std::optional<SamplingFailure> MultiplexedEstimator::measure(std::uint64_t sample) {
  std::optional<SamplingFailure> failure;
  measure_group(sample, {&failure, 1});
  return failure;
}

void MultiplexedEstimator::draw(Side& side, std::uint64_t first, std::span<std::optional<SamplingFailure>> failures) {
  const std::vector<std::span<const double>> loads(side.loads.begin(),
                                                   side.loads.begin() + static_cast<std::ptrdiff_t>(failures.size()));
  side.sampler->draw_group(first, loads, {side.piles.data(), failures.size()}, failures);
}

void MultiplexedEstimator::measure_group(std::uint64_t first, std::span<std::optional<SamplingFailure>> failures) {
  std::vector<std::optional<SamplingFailure>> of_opposite(side_.piles.size());
  for (std::size_t done = 0; done < failures.size(); done += side_.piles.size()) {
    const std::size_t count = std::min(side_.piles.size(), failures.size() - done);
    for (std::size_t k = 0; k < count; ++k) choose_loads(first + done + k, k);
    draw(side_, first + done, failures.subspan(done, count));
    if (spec_.opposite) draw(opposite_, first + done, {of_opposite.data(), count});
    for (std::size_t k = 0; k < count; ++k) {
      if (!failures[done + k]) failures[done + k] = of_opposite[k];
      if (!failures[done + k]) add(k);
    }
  }
  counts_ = sampler_->counts();
  if (chain_) counts_ += chain_->counts();
}

void MultiplexedEstimator::add(std::size_t k) {
  assert_identities(side_.piles[k]);
  if (spec_.opposite) {
    assert_identities(opposite_.piles[k]);
    numbers_.add_mean(side_.piles[k], opposite_.piles[k]);
  } else {
    numbers_.add(side_.piles[k]);
  }
  if (!profiles_) return;
  sign_spectrum_ = signs_[k];
  fourier_.transform(sign_spectrum_);
  add_correlation(k);
}

void MultiplexedEstimator::find_variation(std::size_t k, std::size_t row) {
  const Pile& pile = side_.piles[k];
  for (std::size_t i = 0; i < columns_; ++i) spectrum_[i] = pile.V_R[row + i] + pile.V_L[row + i] - 1;
  if (!spec_.opposite) return;
  const Pile& opposite = opposite_.piles[k];
  for (std::size_t i = 0; i < columns_; ++i) {
    spectrum_[i] = (spectrum_[i] - (opposite.V_R[row + i] + opposite.V_L[row + i] - 1)) / 2;
  }
}

void MultiplexedEstimator::add_correlation(std::size_t k) {
  const std::size_t columns = columns_;
  const double scale = 1 / (static_cast<double>(columns) * spec_.epsilon);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    find_variation(k, static_cast<std::size_t>(layers_[l]) * columns);
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
