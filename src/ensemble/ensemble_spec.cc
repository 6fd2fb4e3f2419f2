#include "ensemble/ensemble_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "sampling/random_key.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

std::uint64_t groups_of(std::uint64_t samples) { return samples / group_size + (samples % group_size != 0 ? 1 : 0); }

}  // namespace

std::string name_of(Load load) { return load == Load::uniform ? "uniform" : "point"; }

Load load_named(const std::string& name) {
  for (Load load : {Load::uniform, Load::point}) {
    if (name_of(load) == name) return load;
  }
  throw InputError(fmt::format("there is no load \"{}\": known are uniform and point", name));
}

SampleRange samples_of(const EnsembleSpec& spec, int block, std::uint64_t group) {
  const std::uint64_t groups = groups_of(spec.response.samples);
  const auto blocks = static_cast<std::uint64_t>(spec.response.blocks), at = static_cast<std::uint64_t>(block);
  const auto from = [&](std::uint64_t number) { return std::min(number * group_size, spec.response.samples); };
  if (spec.layout == BlockLayout::interleaved) {
    const std::uint64_t number = group * blocks + at;
    return {from(number), from(number + 1)};
  }
  const std::uint64_t number = groups * at / blocks + group;
  if (number >= groups * (at + 1) / blocks) return {};
  return {from(number), from(number + 1)};
}

std::uint64_t groups_per_block(const EnsembleSpec& spec) {
  const auto blocks = static_cast<std::uint64_t>(spec.response.blocks);
  return (groups_of(spec.response.samples) + blocks - 1) / blocks;
}

std::vector<int> recorded_layers(const EnsembleSpec& spec) {
  std::vector<int> layers = spec.layers;
  if (layers.empty()) {
    layers.resize(static_cast<std::size_t>(spec.lattice.layers));
    std::iota(layers.begin(), layers.end(), 0);
  } else if (spec.response.estimator == EstimatorName::multiplexed && layers.front() != 0) {
    layers.insert(layers.begin(), 0);
  }
  return layers;
}

int most_sign_run(const Lattice& lattice) { return std::max(1, lattice.columns() / 8); }

void validate(const EnsembleSpec& spec) {
  const Lattice lattice(spec.lattice);
  if (spec.response.blocks < min_blocks) {
    throw InputError(
        fmt::format("{} blocks are too few: a jackknife over fewer than {} blocks gives no usable standard "
                    "error",
                    spec.response.blocks, min_blocks));
  }
  if (groups_of(spec.response.samples) < static_cast<std::uint64_t>(spec.response.blocks)) {
    throw InputError(fmt::format(
        "{} samples are too few: each of the {} blocks needs at least one group of {} samples; ask for {} or more",
        spec.response.samples, spec.response.blocks, group_size,
        (static_cast<std::uint64_t>(spec.response.blocks) - 1) * group_size + 1));
  }
  if (spec.response.samples > max_samples) {
    throw InputError(
        fmt::format("{} samples are too many: one seed names {}; ask for fewer, or divide them among seeds",
                    spec.response.samples, max_samples));
  }
  if (!(spec.response.overload > 0) || !std::isfinite(spec.response.overload)) {
    throw InputError(fmt::format("overload {} is not a positive finite force: there would be no response to measure",
                                 spec.response.overload));
  }
  if (!(spec.response.epsilon > 0 && spec.response.epsilon < 1)) {
    throw InputError(
        fmt::format("epsilon {} is out of range: at 0 there is no response to measure, and at 1 some top beads would "
                    "carry no load, for which there is no solution at small friction; give more than 0 and less than 1",
                    spec.response.epsilon));
  }
  if (spec.response.sign_run < 1 || spec.response.sign_run > most_sign_run(lattice)) {
    throw InputError(
        fmt::format("sign_run {} is out of range: at least one bead, and at most an eighth of the {} columns, so that "
                    "every wave of the response meets loads that differ",
                    spec.response.sign_run, lattice.columns()));
  }
  if (spec.response.estimator != EstimatorName::multiplexed &&
      (spec.response.opposite || spec.response.sign_run != 1)) {
    throw InputError(fmt::format(
        "opposite and sign_run belong to the estimator multiplexed and would change nothing under {}; leave them out",
        name_of(spec.response.estimator)));
  }
  if (spec.response.estimator != EstimatorName::point && spec.load != Load::point) {
    throw InputError(fmt::format("the estimator {} brings its own loads; leave the load at point",
                                 name_of(spec.response.estimator)));
  }
  if (std::adjacent_find(spec.layers.begin(), spec.layers.end(), std::greater_equal<>()) != spec.layers.end()) {
    throw InputError("the recorded layers are not ascending: each may be named once, from the top down");
  }
  for (int layer : spec.layers) {
    if (layer < 0 || layer >= lattice.layers()) {
      throw InputError(fmt::format("layer {} is outside the lattice of {} layers (0 to {})", layer, lattice.layers(),
                                   lattice.layers() - 1));
    }
  }
}

std::string configuration_text(const EnsembleSpec& spec) {
  const SamplerSpec& s = spec.sampler;
  const bool point = spec.response.estimator == EstimatorName::point,
             multiplexed = spec.response.estimator == EstimatorName::multiplexed;
  // The lines of the estimator point are older than the choice of estimators; ensembles drawn then stay valid.
  const std::string estimator = point ? ""
                                      : fmt::format("estimator={}\nepsilon={}\n", name_of(spec.response.estimator),
                                                    multiplexed ? exact(spec.response.epsilon) : "0");
  // What was not always summed.
  const std::string sums = spec.response.estimator == EstimatorName::paired ? "sums=response_thrust\n" : "";
  // Likewise of their options,
  const std::string options = (spec.response.opposite ? "opposite=true\n" : "") +
                              (spec.response.sign_run != 1 ? fmt::format("sign_run={}\n", spec.response.sign_run) : "");
  // and the keys of the law polytope.
  const std::string chain = s.law == Law::polytope ? fmt::format("lambda={}\nburn_in={}\nthinning={}\n",
                                                                 exact(s.lambda), s.burn_in, s.thinning)
                                                   : "";
  // And the rules of the law granusolve.
  const std::string rules = s.rules != MendingRules::all ? fmt::format("rules={}\n", name_of(s.rules)) : "";
  // And the layout of the blocks.
  const std::string layout = spec.layout == BlockLayout::interleaved ? "blocks_of=interleaved\n" : "";
  const bool overloaded = spec.response.estimator == EstimatorName::paired || (point && spec.load == Load::point);
  return fmt::format(
      "sampling_version={}\nlaw={}\nmu={}\nseed={}\neffort={}\nmax_tries={}\norder={}\n{}columns={}\nlayers={}\nload={}"
      "\n"
      "overload={}\nsamples={}\nblocks={}\nrecorded_layers={}\nprofiles={}\n{}{}",
      sampling_version, name_of(s.law), exact(s.mu), s.seed, exact(s.effort), s.max_tries, name_of(s.order), chain,
      spec.lattice.columns, spec.lattice.layers, point ? name_of(spec.load) : name_of(spec.response.estimator),
      overloaded ? exact(spec.response.overload) : "0", spec.response.samples, spec.response.blocks,
      fmt::join(recorded_layers(spec), ","), spec.record_profiles, estimator, options + rules + layout + sums);
}

std::vector<double> top_load(const EnsembleSpec& spec) {
  const Lattice lattice(spec.lattice);
  std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  if (spec.load == Load::point) load[static_cast<std::size_t>(lattice.middle())] += spec.response.overload;
  return load;
}

std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample) {
  const bool point = spec.response.estimator == EstimatorName::point,
             multiplexed = spec.response.estimator == EstimatorName::multiplexed;
  std::string command = fmt::format("granuscope sample --law {} --mu {} --columns {} --layers {} --load {}",
                                    name_of(spec.sampler.law), exact(spec.sampler.mu), spec.lattice.columns,
                                    spec.lattice.layers, point ? name_of(spec.load) : name_of(spec.response.estimator));
  if (multiplexed) command += fmt::format(" --epsilon {}", exact(spec.response.epsilon));
  if (spec.response.opposite) command += " --opposite";
  if (spec.response.sign_run != 1) command += fmt::format(" --sign-run {}", spec.response.sign_run);
  if (!multiplexed && spec.load == Load::point && spec.response.overload != 1.0)
    command += fmt::format(" --overload {}", exact(spec.response.overload));
  if (spec.sampler.effort != SamplerSpec{}.effort) command += fmt::format(" --effort {}", exact(spec.sampler.effort));
  if (spec.sampler.max_tries != SamplerSpec{}.max_tries)
    command += fmt::format(" --max-tries {}", spec.sampler.max_tries);
  if (spec.sampler.law == Law::polytope) {
    command += fmt::format(" --lambda {}", exact(spec.sampler.lambda));
    if (spec.sampler.burn_in > 0) command += fmt::format(" --burn-in {}", spec.sampler.burn_in);
    if (spec.sampler.thinning > 0) command += fmt::format(" --thinning {}", spec.sampler.thinning);
  }
  if (spec.sampler.rules != SamplerSpec{}.rules) command += " --mending-rules " + name_of(spec.sampler.rules);
  if (spec.sampler.order != SamplerSpec{}.order) command += " --layer-order " + name_of(spec.sampler.order);
  return command + fmt::format(" --seed {} --sample {} --out pile.h5", spec.sampler.seed, sample);
}

}  // namespace granuscope
