#include "ensemble/estimator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace granuscope {
namespace {

constexpr std::size_t of_mode = correlation_parts * group_lanes;
/// The most memory that the modes of layers take, unless one base and its lags need more.
constexpr std::size_t most_memory = std::size_t{8} << 20;  // bytes

std::size_t most_modes(const FluctuationPlan& plan) {
  return static_cast<std::size_t>(*std::ranges::max_element(plan.modes));
}

/// Layers whose modes are held at once: at least those of one base, at most all.
std::size_t layers_at_once(const FluctuationPlan& plan) {
  const int reach = plan.reference + plan.lags.back();
  // From a base to its last partner lie partners of other bases, too.
  std::ptrdiff_t of_one = 0;
  for (const int base : plan.bases) {
    const auto from = std::lower_bound(plan.layers.begin(), plan.layers.end(), base);
    of_one = std::max(of_one, std::upper_bound(from, plan.layers.end(), base + reach) - from);
  }
  const std::size_t held = most_memory / (most_modes(plan) * of_mode * sizeof(double));
  return std::min(plan.layers.size(), std::max(held, 2 * static_cast<std::size_t>(of_one)));
}

}  // namespace

std::vector<QuantityShape> FluctuationEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerObservables::quantities(spec);
  if (spec.record_profiles) all.push_back({"propagation", 2 * spec.lattice.columns});
  return all;
}

KeptLayers FluctuationEstimator::layers_to_keep(const EnsembleSpec& spec) {
  return {fluctuation_plan(spec).layers, true};
}

double FluctuationEstimator::memory(const EnsembleSpec& spec) {
  const FluctuationPlan plan = fluctuation_plan(spec);
  const double modes = static_cast<double>(most_modes(plan) * of_mode * sizeof(double));
  return modes * static_cast<double>(layers_at_once(plan) + plan.lags.size());
}

FluctuationEstimator::FluctuationEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block)
    : plan_(fluctuation_plan(spec)),
      columns_(static_cast<std::size_t>(spec.lattice.columns)),
      modes_(most_modes(plan_)),
      room_(layers_at_once(plan_)),
      parts_(is_scalar(spec.sampler.model) ? 1 : correlation_parts),
      rows_(rows_of(spec.sampler.model, spec.lattice.angle)),
      load_(top_load(spec)),
      loads_(piles_at_once(spec), load_),
      sampler_(samplers.first),
      fourier_(columns_),
      re_(aligned_array<double>(columns_ * group_lanes)),
      im_(aligned_array<double>(columns_ * group_lanes)),
      fields_(aligned_array<double>(modes_ * room_ * of_mode)),
      correlations_(aligned_array<double>(modes_ * plan_.lags.size() * of_mode)),
      place_(static_cast<std::size_t>(spec.lattice.layers), -1),
      pairs_(plan_.lags.size()),
      observables_(spec, sums, block),
      profiles_(spec.record_profiles),
      propagation_(profiles_ ? BlockSlice(sums, "propagation", block) : BlockSlice()) {
  for (std::size_t m = 1; m <= modes_; ++m) {
    const double angle = -std::numbers::pi * static_cast<double>(m) / static_cast<double>(columns_);
    phases_[0].push_back({});
    phases_[1].push_back({std::cos(angle), std::sin(angle)});
  }
}

std::optional<SamplingFailure> FluctuationEstimator::measure(std::uint64_t sample) {
  std::optional<SamplingFailure> failure;
  measure_samples({&sample, 1}, {&failure, 1});
  return failure;
}

void FluctuationEstimator::measure_samples(std::span<const std::uint64_t> samples,
                                           std::span<std::optional<SamplingFailure>> failures) {
  draw_alike(sampler_, loads_, samples, failures, [&](const PileGroup& group, auto of_group) { add(group, of_group); });
}

void FluctuationEstimator::add(const PileGroup& group, Failures failures) {
  assert_identities(group, failures);
  observables_.add_means(group, failures, plan_.bases, plan_.reference);
  if (!profiles_) return;
  std::fill_n(correlations_.get(), modes_ * plan_.lags.size() * of_mode, 0.0);
  const int reach = plan_.reference + plan_.lags.back();
  const auto held_from = [&](int layer) {
    return std::lower_bound(plan_.layers.begin(), plan_.layers.end(), layer) - plan_.layers.begin();
  };
  std::ptrdiff_t first = 0, end = 0;  // of the layers that fields_ holds
  for (std::size_t base = 0; base < plan_.bases.size();) {
    // Those that later bases need move to the front, and as many more follow as there is room for.
    const std::ptrdiff_t from = held_from(plan_.bases[base]);
    if (from > first && end > from) {
      for (std::size_t m = 0; m < modes_; ++m) {
        double* const mode = &fields_[m * room_ * of_mode];
        std::copy(mode + static_cast<std::size_t>(from - first) * of_mode,
                  mode + static_cast<std::size_t>(end - first) * of_mode, mode);
      }
    }
    first = from;
    end = std::max(end, first);
    std::size_t last_base = base;
    while (last_base < plan_.bases.size() &&
           held_from(plan_.bases[last_base] + reach) - first < static_cast<std::ptrdiff_t>(room_)) {
      ++last_base;
    }
    const std::ptrdiff_t new_end = held_from(plan_.bases[last_base - 1] + reach) + 1;
    for (; end < new_end; ++end) {
      transform_layer(group, failures, plan_.layers[static_cast<std::size_t>(end)],
                      static_cast<std::size_t>(end - first));
    }
    for (std::ptrdiff_t i = first; i < end; ++i) {
      place_[static_cast<std::size_t>(plan_.layers[static_cast<std::size_t>(i)])] = static_cast<int>(i - first);
    }
    compare_layers(base, last_base);
    base = last_base;
  }
  add_sums(group.piles, failures);
}

/// The modes of w - 1 and H of a layer from one transform of w - 1 + i H. Piles that failed, and lanes without one, are
/// 0.
void FluctuationEstimator::transform_layer(const PileGroup& group, Failures failures, int layer, std::size_t place) {
  const std::size_t row = group.row(layer);
  for (std::size_t i = 0; i < columns_; ++i) {
    const std::size_t from = row + i * group.stride, to = i * group_lanes;
    for (std::size_t k = 0; k < group.piles; ++k) {
      re_[to + k] = group.weight(from + k) - 1;
      im_[to + k] = group.H(from + k);
    }
  }
  for (std::size_t k = 0; k < group_lanes; ++k) {
    if (k < group.piles && !failures[k]) continue;
    for (std::size_t i = 0; i < columns_; ++i) re_[i * group_lanes + k] = im_[i * group_lanes + k] = 0;
  }
  fourier_.transform(re_.get(), im_.get());
  separate_fields(re_.get(), im_.get(), columns_, phases_[rows_.shifted(layer) ? 1 : 0], room_ * of_mode,
                  &fields_[place * of_mode]);
}

void FluctuationEstimator::compare_layers(std::size_t first_base, std::size_t end_base) {
  const auto place = [&](int layer) { return place_[static_cast<std::size_t>(layer)]; };
  for (std::size_t l = 0; l < plan_.lags.size(); ++l) {
    pairs_[l].clear();
    for (std::size_t b = first_base; b < end_base; ++b) {
      pairs_[l].push_back(place(plan_.bases[b]));
      pairs_[l].push_back(place(plan_.bases[b] + plan_.reference + plan_.lags[l]));
    }
  }
  for (std::size_t m = 0; m < modes_; ++m) {
    for (std::size_t l = 0; l < plan_.lags.size(); ++l) {
      if (m >= static_cast<std::size_t>(plan_.modes[l])) continue;
      add_correlations(&fields_[m * room_ * of_mode], pairs_[l], &correlations_[(m * plan_.lags.size() + l) * of_mode]);
    }
  }
}

void FluctuationEstimator::add_sums(std::size_t piles, Failures failures) {
  const double scale = 1 / (static_cast<double>(columns_) * static_cast<double>(plan_.bases.size()));
  for (std::size_t l = 0; l < plan_.lags.size(); ++l) {
    const auto modes = static_cast<std::size_t>(plan_.modes[l]);
    for (std::size_t m = 0; m < modes; ++m) {
      const double* const from = &correlations_[(m * plan_.lags.size() + l) * of_mode];
      for (std::size_t part = 0; part < parts_; ++part) {
        for (std::size_t k = 0; k < piles; ++k) {
          if (!failures[k]) propagation_.add(l, correlation_parts * m + part, scale * from[part * group_lanes + k]);
        }
      }
    }
  }
}

namespace {

constexpr double most_of_lag = 4.5, most_of_reference = 3;  ///< k W
constexpr double smallest = 0.1;                            ///< W^2 of the shortest lags

/// Growth of W^2 per bead diameter, of beads within a third of what was measured at mu = 0.1 to 0.8; under the law
/// polytope, where W^2 is no power of z near 1, of what it was at z = 14 and mu = 0.5.
double spreading_of(const SamplerSpec& sampler) {
  constexpr double slope = 2.4, of_polytope = 10, power = 2.7;
  return sampler.model.has_contacts()
             ? (sampler.law == Law::polytope ? of_polytope : slope) * std::pow(sampler.mu, power)
             : rough_spreading(sampler.model);
}

/// The highest mode on a ring of `columns` that tells something of a lag: where k W = 4.5 for a rough W(lag), so that
/// the response has fallen to 4e-5 and the mode counts less than 1 % in the fit that x_p and W come from
/// (shape_fit.h); or where k W(reference) = 3, if that is less: the noise is divided by exp(-k^2
/// W(reference)^2/2).
int weighty_modes(const SamplerSpec& sampler, int columns, int lag, int reference) {
  const auto width = [&](int layers) {
    return std::sqrt(smallest + spreading_of(sampler) * layers * rows_of(sampler.model).spacing);
  };
  const double k = std::min(most_of_lag / width(lag), most_of_reference / width(reference));
  const int all = (columns - 1) / 2;
  return std::clamp(static_cast<int>(k * columns / (2 * std::numbers::pi)), std::min(4, all), all);
}

/// Layers below which uniformly loaded piles fluctuate as deep ones do: 0.6/mu^2 of beads, at least 60 and at most
/// 2000. Of legs that push twice the deepest lag, so that waves as long as its peak is wide are there (from layer 60 on
/// W^2 was 5 to 16 % smaller than from layer 2000 on). Models whose noise acts linearly respond alike in any layer.
int saturated_layer(const SamplerSpec& sampler, int deepest_lag) {
  constexpr double shallowest = 60, deepest = 2000, times_mu_squared = 0.6;
  const ModelSpec& model = sampler.model;
  if (model.name == ModelName::three_leg && model.three_leg.law != MiddleLaw::free)
    return std::max(static_cast<int>(shallowest), 2 * deepest_lag);
  if (!model.has_contacts() || !(sampler.mu > 0)) return static_cast<int>(shallowest);
  return static_cast<int>(std::clamp(times_mu_squared / (sampler.mu * sampler.mu), shallowest, deepest));
}

/// The common divisor of the distances between lags: bases and references that keep to it need the fewest layers.
int spacing_of(const std::vector<int>& lags) {
  int spacing = 0;
  for (std::size_t i = 2; i < lags.size(); ++i) spacing = std::gcd(spacing, lags[i] - lags[i - 1]);
  return std::max(1, spacing);
}

std::vector<int> layers_of(const FluctuationPlan& plan) {
  std::vector<int> layers = plan.bases;
  for (const int base : plan.bases) {
    for (const int lag : plan.lags) layers.push_back(base + plan.reference + lag);
  }
  std::ranges::sort(layers);
  layers.erase(std::unique(layers.begin(), layers.end()), layers.end());
  return layers;
}

}  // namespace

FluctuationPlan fluctuation_plan(const EnsembleSpec& spec) {
  const ResponseSpec& response = spec.response;
  const SamplerSpec sampler = like_at_30(spec);
  FluctuationPlan plan;
  plan.lags = recorded_layers(spec);
  const int spacing = spacing_of(plan.lags), last = plan.lags.back();
  const int step = (response.base_step + spacing - 1) / spacing * spacing;
  const int first = response.first_base > 0 ? response.first_base : saturated_layer(sampler, last);
  // The deepest lag then falls on a layer as far from a base as lags are apart.
  plan.reference = response.reference_lag;
  while ((plan.reference + last) % spacing != 0) ++plan.reference;
  const int unused = bottom_margin_of(spec.sampler.model);
  plan.layers_needed = first + plan.reference + last + unused + 1;
  for (int base = first; base + plan.reference + last + unused < spec.lattice.layers; base += step) {
    plan.bases.push_back(base);
  }
  for (const int lag : plan.lags) {
    // The reference serves every lag.
    const int shallowest = lag == 0 && plan.lags.size() > 1 ? plan.lags[1] : lag;
    plan.modes.push_back(weighty_modes(sampler, spec.lattice.columns, shallowest, plan.reference));
  }
  plan.layers = layers_of(plan);
  return plan;
}

}  // namespace granuscope
