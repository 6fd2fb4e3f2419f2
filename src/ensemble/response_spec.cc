#include "ensemble/response_spec.h"

#include <algorithm>
#include <cmath>

namespace granuscope {

int longest_run(const LatticeSpec& lattice) { return std::max(1, lattice.columns / 8); }

Problem find_problem(const ResponseSpec& spec, const LatticeSpec& lattice) {
  if (!(spec.epsilon >= least_epsilon && spec.epsilon < epsilon_limit)) {
    return problem(
        "epsilon",
        "{} cannot be measured: some top beads carry 1 - epsilon, and one without load has no solution beside "
        "loaded ones at small friction, while the response is divided by epsilon; give {} to less than {} "
        "(0.25 is usual)",
        spec.epsilon, least_epsilon, epsilon_limit);
  }
  if (spec.estimator != EstimatorName::multiplexed && (spec.opposite || spec.sign_run != ResponseSpec{}.sign_run)) {
    return problem(spec.opposite ? "opposite" : "sign_run",
                   "it belongs to the estimator multiplexed and would change nothing under {}; leave it out, or "
                   "choose that estimator",
                   name_of(spec.estimator));
  }
  const ResponseSpec usual;
  if (spec.estimator != EstimatorName::fluctuation &&
      (spec.reference_lag != usual.reference_lag || spec.first_base != usual.first_base ||
       spec.base_step != usual.base_step)) {
    return problem(spec.reference_lag != usual.reference_lag ? "reference_lag"
                   : spec.first_base != usual.first_base     ? "first_base"
                                                             : "base_step",
                   "it belongs to the estimator fluctuation and would change nothing under {}; leave it out, or choose "
                   "that estimator",
                   name_of(spec.estimator));
  }
  if (spec.reference_lag < 0 || spec.reference_lag > most_reference_lag) {
    return problem("reference_lag",
                   "{} layers cannot be measured; give 0 to {} (24 is usual, fewer than 12 are biased)",
                   spec.reference_lag, most_reference_lag);
  }
  if (spec.first_base < 0 || spec.first_base > most_first_base) {
    return problem("first_base", "layer {} is no base; give 0 (where the fluctuations are saturated) to {}",
                   spec.first_base, most_first_base);
  }
  if (spec.base_step < 1 || spec.base_step > most_base_step) {
    return problem("base_step", "{} layers between two bases; give 1 to {} (6 is usual)", spec.base_step,
                   most_base_step);
  }
  if (spec.sign_run < 1 || spec.sign_run > longest_run(lattice)) {
    return problem(
        "sign_run",
        "{} beads: a run has at least one, and where fewer than eight runs fit into a ring of {} columns the "
        "long waves meet hardly any load that differs; give 1 to {} (1 to 3 is usual)",
        spec.sign_run, lattice.columns, longest_run(lattice));
  }
  if (!(std::isfinite(spec.overload) && spec.overload >= least_overload && spec.overload <= most_overload)) {
    return problem("overload",
                   "{} cannot be measured: the response is divided by the overload, and the load "
                   "of its neighbours is 1; give {} to {} (the paper has 1)",
                   spec.overload, least_overload, most_overload);
  }
  if (spec.blocks < min_blocks || spec.blocks > most_blocks) {
    return problem("blocks",
                   "{} blocks: fewer than {} give no reliable standard error, and more than {} no "
                   "better one; give {} to {} (32 is usual)",
                   spec.blocks, min_blocks, most_blocks, min_blocks, most_blocks);
  }
  const std::uint64_t least = group_size * static_cast<std::uint64_t>(spec.blocks - 1) + 1;
  if (spec.samples > most_samples) {
    return problem("samples", "{} samples are too many; give {} to {}, or divide them among seeds", spec.samples, least,
                   most_samples);
  }
  if (spec.samples < least) {
    return problem("samples",
                   "{} samples are too few: each of the {} blocks needs at least one group of {}; give {} or more",
                   spec.samples, spec.blocks, group_size, least);
  }
  return {};
}

}  // namespace granuscope
