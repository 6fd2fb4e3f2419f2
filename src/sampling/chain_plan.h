#pragma once
#include <span>

#include "model/lattice.h"
#include "sampling/sampler_spec.h"

namespace granuscope {

/// How long the chains of the law "polytope" run.
struct ChainPlan {
  std::uint64_t burn_in = 0;        ///< sweeps before the first pile
  std::uint64_t thinning = 0;       ///< sweeps from a pile to the next
  double autocorrelation_time = 0;  ///< sweeps that weigh as much as one independent pile, of the slowest observable
  std::uint64_t pilot_sweeps = 0;   ///< over which it was measured
};

/// Sweeps at lambda = 0 with which every chain begins: they lead away from corners where a length vanishes, which a
/// sweep at lambda = 1 would hardly ever leave.
inline constexpr std::uint64_t flat_sweeps = 8;

/// Burn-in and thinning in units of the autocorrelation time of the slowest observable. That time is about twice the
/// one in which it decays by e: what the start leaves behind is e^-8 of its distance from the law.
inline constexpr double burn_in_times = 4, thinning_times = 0.5;

/// Runs a pilot chain (keyed by the seed alone) until it is a hundred times as long as the autocorrelation time of its
/// slowest observable: the thrusts of up to eight layers, and the excess of the weight on one half of each of them over
/// the other half, the halves being cut at two places a quarter apart. A pure function of its arguments.
/// Throws InputError if the chain is still too short after 2^22 sweeps: the pile is too large for this law, or the
/// pilot could not be started.
ChainPlan plan_chain(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load);

/// How long chains would run, and how quickly, from the beginning of the pilot alone.
struct ChainForecast {
  ChainPlan plan;                ///< as plan_chain would give it, about; pilot_sweeps is 0 where nothing is measured
  double seconds_per_sweep = 0;  ///< of processor time, on this machine
  bool known = false;            ///< false: time ran out before the pilot was long enough to tell; more may be needed
};

/// Runs at most so many seconds of the pilot (of processor time; at least some sweeps). Where burn_in and thinning are
/// both stated, only the speed is measured. Throws InputError if the pilot could not be started.
ChainForecast estimate_chain_time(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load,
                                  double seconds);

/// The spec with burn_in and thinning measured where they are 0, for the law "polytope" at mu > 0; otherwise as it is.
/// The piles are the same; what is saved is one pilot for every sampler made. What was measured is remembered for as
/// long as the program runs.
SamplerSpec with_measured_chain(SamplerSpec spec, const Lattice& lattice, std::span<const double> load);

/// The law "granusolve", without what belongs to the chain alone: it draws the piles that chains start from.
SamplerSpec start_of_chain(const SamplerSpec& spec);

}  // namespace granuscope
