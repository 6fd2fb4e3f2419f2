#include "ensemble/estimator.h"

#include <gsl/gsl_fft_halfcomplex.h>
#include <gsl/gsl_fft_real.h>

#include <algorithm>
#include <new>
#include <stdexcept>

#include "sampling/random_key.h"

namespace granuscope {
namespace {

bool records_H(const EnsembleSpec& spec) { return spec.record_profiles && spec.record_H; }

}  // namespace

std::vector<QuantityShape> MultiplexedEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerObservables::quantities(spec);
  if (spec.record_profiles) all.push_back({"correlation", spec.lattice.columns});
  if (records_H(spec)) all.push_back({"correlation_H", spec.lattice.columns});
  return all;
}

KeptLayers MultiplexedEstimator::layers_to_keep(const EnsembleSpec& spec) {
  return {recorded_layers(spec), records_H(spec)};
}

MultiplexedEstimator::MultiplexedEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block)
    : spec_(spec),
      columns_(static_cast<std::size_t>(spec.lattice.columns)),
      sign_spectrum_(columns_),
      spectrum_(columns_),
      fourier_(columns_),
      samplers_(samplers),
      layers_(sums.layers),
      observables_(spec, sums, block),
      profiles_(spec.record_profiles),
      has_H_(records_H(spec)),
      correlation_(profiles_ ? BlockSlice(sums, "correlation", block) : BlockSlice()),
      correlation_H_(has_H_ ? BlockSlice(sums, "correlation_H", block) : BlockSlice()) {
  const std::size_t at_once = piles_at_once(spec);
  // With their opposites, whole groups; two of them are drawn at once.
  signs_.assign(spec.response.opposite ? std::min(at_once, group_lanes) : at_once, std::vector<double>(columns_));
  loads_.assign(spec.response.opposite ? 2 * signs_.size() : signs_.size(), signs_.front());
}

void MultiplexedEstimator::choose_loads(std::uint64_t sample, std::size_t k) {
  draw_signs(spec_, sample, signs_[k]);
  for (std::size_t i = 0; i < columns_; ++i) {
    loads_[k][i] = 1 + spec_.response.epsilon * signs_[k][i];
    if (spec_.response.opposite) loads_[signs_.size() + k][i] = 1 - spec_.response.epsilon * signs_[k][i];
  }
}

std::optional<SamplingFailure> MultiplexedEstimator::measure(std::uint64_t sample) {
  std::optional<SamplingFailure> failure;
  measure_samples({&sample, 1}, {&failure, 1});
  return failure;
}

/// Fills side_ and opposite_ with as many groups each. A sample is drawn if both its piles are.
void MultiplexedEstimator::draw(std::span<const std::uint64_t> samples,
                                std::span<std::optional<SamplingFailure>> failures) {
  const std::size_t count = samples.size();
  drawn_loads_.assign(loads_.begin(), loads_.begin() + static_cast<std::ptrdiff_t>(count));
  if (!spec_.response.opposite) {
    const auto groups = samplers_.first.draw_groups(samples, drawn_loads_, failures);
    side_.assign(groups.begin(), groups.end());
    return;
  }
  for (std::size_t k = 0; k < count; ++k) drawn_loads_.push_back(loads_[signs_.size() + k]);
  const std::span<const std::span<const double>> both = drawn_loads_;
  std::vector<std::optional<SamplingFailure>> of_both(2 * count);
  const std::span<std::optional<SamplingFailure>> failed = of_both;
  if (&samplers_.first != &samplers_.second) {
    const auto side = samplers_.first.draw_groups(samples, both.first(count), failed.first(count));
    const auto opposite = samplers_.second.draw_groups(samples, both.last(count), failed.last(count));
    side_.assign(side.begin(), side.end());
    opposite_.assign(opposite.begin(), opposite.end());
  } else {
    std::vector<std::uint64_t> twice(samples.begin(), samples.end());
    twice.insert(twice.end(), samples.begin(), samples.end());
    const auto groups = samplers_.first.draw_groups(twice, both, failed);
    side_.assign(groups.begin(), groups.begin() + static_cast<std::ptrdiff_t>(groups.size() / 2));
    opposite_.assign(groups.begin() + static_cast<std::ptrdiff_t>(groups.size() / 2), groups.end());
  }
  for (std::size_t k = 0; k < count; ++k) failures[k] = failed[k] ? failed[k] : failed[count + k];
}

void MultiplexedEstimator::measure_samples(std::span<const std::uint64_t> samples,
                                           std::span<std::optional<SamplingFailure>> failures) {
  for (std::size_t done = 0; done < samples.size(); done += signs_.size()) {
    const std::size_t count = std::min(signs_.size(), samples.size() - done);
    for (std::size_t k = 0; k < count; ++k) choose_loads(samples[done + k], k);
    draw(samples.subspan(done, count), failures.subspan(done, count));
    std::size_t first = 0;
    for (std::size_t g = 0; g < side_.size(); ++g) {
      add(g, first, failures.subspan(done + first, side_[g].piles));
      first += side_[g].piles;
    }
  }
}

/// Group `g`, whose first pile has the signs number `first`.
void MultiplexedEstimator::add(std::size_t g, std::size_t first,
                               std::span<const std::optional<SamplingFailure>> failures) {
  assert_identities(side_[g], failures);
  if (spec_.response.opposite) {
    assert_identities(opposite_[g], failures);
    observables_.add_mean(side_[g], opposite_[g], failures);
  } else {
    observables_.add(side_[g], failures);
  }
  for (std::size_t k = 0; profiles_ && k < side_[g].piles; ++k) {
    if (failures[k]) continue;
    sign_spectrum_ = signs_[first + k];
    fourier_.transform(sign_spectrum_);
    add_correlations(g, k);
  }
}

void MultiplexedEstimator::add_correlations(std::size_t g, std::size_t k) {
  for (std::size_t row = 0; row < layers_.size(); ++row) {
    const int layer = layers_[row];
    find_variation(g, k, layer, mean_weight(side_[g].bead_weight, layer),
                   [](const PileGroup& group, std::size_t entry) { return group.weight(entry); });
    add_correlation(correlation_, row);
    if (!has_H_) continue;
    find_variation(g, k, layer, 0, [](const PileGroup& group, std::size_t entry) { return group.H(entry); });
    add_correlation(correlation_H_, row);
  }
}

template <typename Value>
void MultiplexedEstimator::find_variation(std::size_t g, std::size_t k, int layer, double mean, Value value) {
  const auto of_bead = [&](const PileGroup& group, std::size_t i) {
    return value(group, group.row(layer) + i * group.stride + k) - mean;
  };
  for (std::size_t i = 0; i < columns_; ++i) spectrum_[i] = of_bead(side_[g], i);
  if (!spec_.response.opposite) return;
  for (std::size_t i = 0; i < columns_; ++i) spectrum_[i] = (spectrum_[i] - of_bead(opposite_[g], i)) / 2;
}

void MultiplexedEstimator::add_correlation(BlockSlice& correlation, std::size_t row) {
  fourier_.transform(spectrum_);
  const double scale = 1 / (static_cast<double>(columns_) * spec_.response.epsilon);
  correlation.add(row, 0, scale * sign_spectrum_[0] * spectrum_[0]);
  for (std::size_t re = 1, im = 2; im < columns_; re += 2, im += 2) {
    const double a = sign_spectrum_[re], b = sign_spectrum_[im], c = spectrum_[re], d = spectrum_[im];
    correlation.add(row, re, scale * (a * c + b * d));
    correlation.add(row, im, scale * (a * d - b * c));
  }
  if (columns_ % 2 == 0) {
    correlation.add(row, columns_ - 1, scale * sign_spectrum_[columns_ - 1] * spectrum_[columns_ - 1]);
  }
}

void draw_signs(std::uint64_t seed, std::uint64_t sample, int run, std::span<double> signs) {
  const RandomKey key(seed, sample);
  const auto fair = [&key](std::size_t bit) { return key.load_bit(static_cast<int>(bit)); };
  const std::size_t columns = signs.size();
  if (run == 1) {
    for (std::size_t i = 0; i < columns; ++i) signs[i] = fair(i) ? 1 : -1;
    return;
  }
  std::size_t i = 0;
  for (std::size_t k = 0; i < columns; ++k) {
    const std::size_t length = static_cast<std::size_t>(run) + (fair(columns + k) ? 1 : 0);
    const double sign = fair(k) ? 1 : -1;
    for (std::size_t j = 0; j < length && i < columns; ++j, ++i) signs[i] = sign;
  }
}

void draw_signs(const EnsembleSpec& spec, std::uint64_t sample, std::span<double> signs) {
  const bool chain = spec.sampler.law == Law::polytope || spec.sampler.model.name == ModelName::diluted_beads;
  const std::uint64_t named = chain ? sample - sample % group_size : sample;
  draw_signs(spec.sampler.seed, named, spec.response.sign_run, signs);
}

namespace {

template <typename T>
T* checked(T* table) {
  if (table == nullptr) throw std::bad_alloc();
  return table;
}

template <typename T, void (*free)(T*)>
struct Free {
  void operator()(T* table) const { free(table); }
};

}  // namespace

struct RealSpectrum::Tables {
  explicit Tables(std::size_t n)
      : size(n),
        forward(checked(gsl_fft_real_wavetable_alloc(n))),
        backward(checked(gsl_fft_halfcomplex_wavetable_alloc(n))),
        work(checked(gsl_fft_real_workspace_alloc(n))) {}
  std::size_t size;
  std::unique_ptr<gsl_fft_real_wavetable, Free<gsl_fft_real_wavetable, gsl_fft_real_wavetable_free>> forward;
  std::unique_ptr<gsl_fft_halfcomplex_wavetable,
                  Free<gsl_fft_halfcomplex_wavetable, gsl_fft_halfcomplex_wavetable_free>>
      backward;
  std::unique_ptr<gsl_fft_real_workspace, Free<gsl_fft_real_workspace, gsl_fft_real_workspace_free>> work;
};

RealSpectrum::RealSpectrum(std::size_t size) : tables_(std::make_unique<Tables>(size)) {}
RealSpectrum::~RealSpectrum() = default;
RealSpectrum::RealSpectrum(RealSpectrum&&) noexcept = default;

void RealSpectrum::transform(std::span<double> ring) const {
  if (ring.size() != tables_->size) throw std::logic_error("a Fourier transform was handed a ring of another size");
  gsl_fft_real_transform(ring.data(), 1, ring.size(), tables_->forward.get(), tables_->work.get());
}

void RealSpectrum::inverse(std::span<double> spectrum) const {
  if (spectrum.size() != tables_->size) throw std::logic_error("a Fourier transform was handed a ring of another size");
  gsl_fft_halfcomplex_inverse(spectrum.data(), 1, spectrum.size(), tables_->backward.get(), tables_->work.get());
}

}  // namespace granuscope
