#include "ensemble/replay.h"

#include <vector>

#include "ensemble/load_signs.h"

namespace granuscope {
namespace {

std::optional<SamplingFailure> replay_pair(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  const auto sampler = make_sampler(spec.sampler, pile.lattice);
  const std::vector<double> uniform(static_cast<std::size_t>(pile.lattice.columns()), 1.0);
  Pile before(pile.lattice);
  if (const auto failure = sampler->draw(sample, uniform, before)) return failure;
  return sampler->draw_again(sample, top_load(spec), before, pile);
}

std::optional<SamplingFailure> replay_signs(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  const auto sampler = make_sampler(spec.sampler, pile.lattice);
  std::vector<double> signs(static_cast<std::size_t>(pile.lattice.columns())), load(signs.size());
  draw_signs(spec, sample, signs);
  for (const double side : {1.0, -1.0}) {
    if (side < 0 && !spec.response.opposite) break;
    for (std::size_t i = 0; i < load.size(); ++i) load[i] = 1 + side * spec.response.epsilon * signs[i];
    if (const auto failure = sampler->draw(sample, load, pile)) return failure;
  }
  return std::nullopt;
}

}  // namespace

std::optional<SamplingFailure> replay(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  switch (spec.response.estimator) {
    case EstimatorName::paired:
      return replay_pair(spec, sample, pile);
    case EstimatorName::multiplexed:
      return replay_signs(spec, sample, pile);
    case EstimatorName::point:
    case EstimatorName::fluctuation:
      break;
  }
  return make_sampler(spec.sampler, pile.lattice)->draw(sample, top_load(spec), pile);
}

}  // namespace granuscope
