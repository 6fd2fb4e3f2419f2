#pragma once
#include <cstdint>
#include <span>

#include "ensemble/ensemble_spec.h"

namespace granuscope {

/// The signs xi_i = +-1 by which the top loads of one sample are varied (estimator multiplexed), a pure function of
/// (seed, sample, run, number of columns).
///
/// run = 1: one fair sign for each bead. run > 1: one for each run of `run` or, by a fair coin, `run` + 1 beads (the
/// last run ends with the ring). Runs move what the loads say from short waves, which no layer below remembers where
/// peaks are wide, to long ones: the power of a wavelength of many runs is `run` times larger. Two lengths, since
/// runs of one length alone would leave the waves that fit into them without any load.
void draw_signs(std::uint64_t seed, std::uint64_t sample, int run, std::span<double> signs);

/// Those of a sample of the ensemble; the eight samples of a chain share theirs, since a chain belongs to one load.
void draw_signs(const EnsembleSpec& spec, std::uint64_t sample, std::span<double> signs);

}  // namespace granuscope
