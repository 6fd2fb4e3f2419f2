#include "ensemble/load_signs.h"

#include "sampling/random_key.h"

namespace granuscope {

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

}  // namespace granuscope
