#include "sampling/row_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/error.h"
#include "support/progress.h"

namespace granuscope {

RowModelSampler::RowModelSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice),
      spec_(spec),
      model_(make_row_model(spec.model, lattice.columns())),
      layers_(static_cast<std::size_t>(lattice.layers())),
      place_(static_cast<std::size_t>(lattice.layers())),
      load_(aligned_array<double>(static_cast<std::size_t>(lattice.columns()) * group_lanes)) {
  std::iota(layers_.begin(), layers_.end(), 0);
  std::iota(place_.begin(), place_.end(), 0);
}

double RowModelSampler::memory(const Lattice& lattice, const KeptLayers* kept) {
  const double rows =
      kept == nullptr ? lattice.layers() : static_cast<double>(kept->layers.size()) * (kept->horizontal ? 2 : 1);
  const double rows_of_model = 8 * 17;  // and of its noise
  return 8 * static_cast<double>(group_lanes) * (rows + rows_of_model) * lattice.columns();
}

std::optional<SamplingFailure> RowModelSampler::draw(std::uint64_t, std::span<const double>, Pile&) {
  throw InputError(
      fmt::format("a pile of the model {} has no contacts as beads have them, so that it cannot be stored, "
                  "rendered or loaded twice; measure it by an ensemble",
                  name_of(spec_.model.name)));
}

void RowModelSampler::keep_layers(const KeptLayers& kept) {
  layers_ = kept.layers;
  horizontal_ = kept.horizontal;
  std::fill(place_.begin(), place_.end(), -1);
  for (std::size_t l = 0; l < layers_.size(); ++l) place_[static_cast<std::size_t>(layers_[l])] = static_cast<int>(l);
  kept_.clear();
}

RowModelSampler::Kept& RowModelSampler::room(std::size_t group) {
  while (kept_.size() <= group) {
    Kept& kept = kept_.emplace_back();
    const std::size_t size = layers_.size() * static_cast<std::size_t>(lattice_.columns()) * group_lanes;
    kept.weights = aligned_array<double>(size);
    if (horizontal_) {
      kept.horizontal = aligned_array<double>(size);
      std::fill_n(kept.horizontal.get(), size, 0.0);  // as it stays in a scalar model
    }
    kept.moments.resize(layers_.size());
    kept.extras.resize(layers_.size() * extra_names(spec_.model).size() * group_lanes);
  }
  return kept_[group];
}

std::span<const PileGroup> RowModelSampler::draw_groups(std::span<const std::uint64_t> samples,
                                                        std::span<const std::span<const double>> loads,
                                                        std::span<std::optional<SamplingFailure>> failures) {
  groups_.clear();
  std::fill(failures.begin(), failures.end(), std::nullopt);
  for (std::size_t done = 0, count = 0; done < samples.size(); done += count) {
    // Runs of consecutive samples, so that two runs of the same ones make groups alike; or of the same one.
    count = 1;
    const std::uint64_t step = done + 1 < samples.size() && samples[done + 1] == samples[done] ? 0 : 1;
    while (count < group_lanes && done + count < samples.size() &&
           samples[done + count] == samples[done] + step * count) {
      ++count;
    }
    throw_if_interrupted();
    LaneSamples lanes;
    for (std::size_t k = 0; k < group_lanes; ++k) lanes[k] = samples[done + std::min(k, count - 1)];
    Kept& kept = room(groups_.size());
    draw_group(lanes, loads.subspan(done, count), kept);
    groups_.push_back({.lattice = lattice_,
                       .stride = group_lanes,
                       .piles = count,
                       .weights = kept.weights.get(),
                       .horizontal = kept.horizontal.get(),
                       .moments = kept.moments,
                       .kept = place_,
                       .loads = loads.subspan(done, count),
                       .residuals = {kept.residuals.data(), count},
                       .extra_names = extra_names(spec_.model),
                       .extras = kept.extras.data(),
                       .mu = 0,
                       .law = name_of(spec_.model.name),
                       .seed = spec_.seed,
                       .first_sample = samples[done],
                       .sample_step = step});
    const auto rows = static_cast<std::uint64_t>(layers_.back()) + 1;
    counts_.tries += count;
    counts_.beads += count * rows * static_cast<std::uint64_t>(lattice_.columns());
    counts_.uniforms += count * model_->uniforms(layers_.back() + 1);
  }
  return groups_;
}

void RowModelSampler::draw_group(const LaneSamples& samples, std::span<const std::span<const double>> loads,
                                 Kept& kept) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  std::array<double, group_lanes> total{};
  for (std::size_t k = 0; k < group_lanes; ++k) {
    const std::span<const double> load = loads[std::min(k, loads.size() - 1)];
    for (std::size_t i = 0; i < columns; ++i) load_[i * group_lanes + k] = load[i];
    total[k] = std::accumulate(load.begin(), load.end(), 0.0);
  }
  kept.residuals = {};
  model_->begin(spec_.seed, samples, load_.get());
  // What is below the last layer that is measured changes nothing above.
  for (int layer = 0; layer <= layers_.back(); ++layer) {
    const int place = place_[static_cast<std::size_t>(layer)];
    if (place < 0) {
      model_->hand_down(layer, nullptr);
      continue;
    }
    const std::size_t to = static_cast<std::size_t>(place) * columns * group_lanes;
    std::copy_n(model_->weight(), columns * group_lanes, kept.weights.get() + to);
    if (horizontal_) {
      const double* const horizontal = model_->horizontal();
      if (horizontal != nullptr) std::copy_n(horizontal, columns * group_lanes, kept.horizontal.get() + to);
    }
    RowSums sums;
    model_->hand_down(layer, &sums);
    keep_row(layer, sums, total, kept);
  }
}

void RowModelSampler::keep_row(int layer, const RowSums& sums, const std::array<double, group_lanes>& total,
                               Kept& kept) const {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  const auto place = static_cast<std::size_t>(place_[static_cast<std::size_t>(layer)]);
  const double* const row = kept.weights.get() + place * columns * group_lanes;
  std::array<double, group_lanes> weight{}, variance{};
  for (std::size_t i = 0; i < columns; ++i) {
    for (std::size_t k = 0; k < group_lanes; ++k) {
      const double w = row[i * group_lanes + k];
      weight[k] += w;
      variance[k] += (w - 1) * (w - 1);
    }
  }
  LayerMoments& moments = kept.moments[place];
  moments.variance = variance;
  const std::size_t extras = extra_names(spec_.model).size();
  for (std::size_t k = 0; k < group_lanes; ++k) {
    // Observables have sqrt(3) of it over the load, which is 1 for beads without friction.
    moments.thrust[k] = sums.thrust[k] / sqrt3;
    const double residual = std::abs(weight[k] - total[k]) / total[k];
    double& worst = kept.residuals[k].weight_sum;
    worst = std::isfinite(residual) ? std::max(worst, residual) : INFINITY;
    for (std::size_t e = 0; e < extras; ++e) {
      kept.extras[(place * extras + e) * group_lanes + k] = sums.extras[e][k] / static_cast<double>(columns);
    }
  }
}

}  // namespace granuscope
