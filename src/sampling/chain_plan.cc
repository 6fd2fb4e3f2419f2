#include "sampling/chain_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>
#include <string>
#include <vector>

#include "model/pile.h"
#include "sampling/autocorrelation.h"
#include "sampling/granusolve.h"
#include "sampling/polytope_chain.h"
#include "support/error.h"
#include "support/interruption.h"
#include "support/processor_time.h"

namespace granuscope {
namespace {

constexpr std::uint64_t fewest_sweeps = 4096, most_pilot_sweeps = std::uint64_t{1} << 22;
/// Length of the pilot in autocorrelation times. The time is then known to about a third.
constexpr double pilot_times = 100;
/// The same for a forecast of how long chains will run, which is content with a factor of two.
constexpr double times_of_estimates = 20;

/// Below which the autocorrelation time hardly is, for telling a pilot that is too short to have seen the slow waves of
/// weight around the ring from one that has: within a factor of two of what pilots measured at lambda = 0 on 6 x 6 to
/// 24 x 30 beads, and a third of it at lambda = 1. It grows with the fourth power of the length of the wave, which is
/// not longer than the pile is deep.
double shortest_time_expected(const SamplerSpec& spec, const Lattice& lattice) {
  const double wave = std::min(lattice.columns(), lattice.layers());
  return 0.02 * wave * wave * wave * wave * (1 + 15 * spec.lambda * spec.mu);
}
constexpr int observed_layers = 8;
/// The pile starts from another law: this share of the pilot is burn-in.
constexpr double discarded_share = 0.25;

/// Series of slow observables, one entry every `stride` sweeps. When it is full, every second entry goes and the
/// stride doubles.
class SlowObservables {
 public:
  SlowObservables(const Lattice& lattice, double total_load) : lattice_(lattice), total_load_(total_load) {
    const int layers = lattice.layers(), step = std::max(1, (layers + observed_layers - 1) / observed_layers);
    // From the bottom, whose neighbours press from one side only, upwards.
    for (int n = layers - 1; n >= 0; n -= step) layers_.push_back(n);
    series_.resize(3 * layers_.size());
  }

  void record(const Pile& pile, std::uint64_t sweep) {
    if (sweep % stride_ != 0) return;
    const int columns = lattice_.columns();
    std::size_t at = 0;
    for (const int n : layers_) {
      double thrust = 0, halves = 0, shifted_halves = 0;
      for (int i = 0; i < columns; ++i) {
        const std::size_t here = lattice_.index(n, i);
        const double weight = pile.V_R[here] + pile.V_L[here];
        thrust += pile.H_R[here] - pile.H_L[here];
        halves += 2 * i < columns ? weight : -weight;
        shifted_halves += 4 * i >= columns && 4 * i < 3 * columns ? weight : -weight;
      }
      series_[at++].push_back(thrust / total_load_);
      series_[at++].push_back(halves / total_load_);
      series_[at++].push_back(shifted_halves / total_load_);
    }
    if (series_[0].size() == 2 * fewest_sweeps) halve();
  }

  /// Sweeps, of the slowest series.
  double autocorrelation_time() const {
    double longest = 1;
    for (const auto& series : series_) {
      const auto first = static_cast<std::ptrdiff_t>(discarded_share * static_cast<double>(series.size()));
      longest = std::max(longest, granuscope::autocorrelation_time({series.begin() + first, series.end()}, 1));
    }
    return longest * static_cast<double>(stride_);
  }

 private:
  void halve() {
    for (auto& series : series_) {
      for (std::size_t k = 0; 2 * k < series.size(); ++k) series[k] = series[2 * k];
      series.resize(series.size() / 2);
    }
    stride_ *= 2;
  }

  Lattice lattice_;
  double total_load_;
  std::vector<int> layers_;
  std::vector<std::vector<double>> series_;
  std::uint64_t stride_ = 1;
};

/// The chain over which the autocorrelation time is measured.
class Pilot {
 public:
  Pilot(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load)
      : spec_(spec),
        chain_(FrictionCone(spec.mu), lattice, 0),
        observables_(lattice, std::accumulate(load.begin(), load.end(), 0.0)),
        key_(spec.seed, 0) {
    Pile start(lattice);
    if (const auto failure = GranusolveSampler(start_of_chain(spec), lattice).draw(0, load, start)) {
      throw InputError(
          fmt::format("the chain of the law polytope starts from a pile of the law granusolve, but none could be "
                      "completed under this load (it got stuck in layer {}); raise the effort or take a more even load",
                      failure->layer));
    }
    chain_.set(start);
  }

  void run_to(std::uint64_t end) {
    for (; sweeps_ < end; ++sweeps_) {
      if (sweeps_ % 64 == 0) throw_if_interrupted();
      if (sweeps_ == flat_sweeps) chain_.set_lambda(spec_.lambda);
      chain_.sweep(
          [&](int layer, int bead) { return key_.pilot_move(layer, bead, static_cast<std::uint32_t>(sweeps_ + 1)); });
      observables_.record(chain_.pile(), sweeps_);
    }
  }

  std::uint64_t sweeps() const { return sweeps_; }
  double autocorrelation_time() const { return observables_.autocorrelation_time(); }

 private:
  SamplerSpec spec_;
  PolytopeChain chain_;
  SlowObservables observables_;
  RandomKey key_;
  std::uint64_t sweeps_ = 0;
};

/// Whether a pilot of so many sweeps holds the time so many times.
bool long_enough(std::uint64_t sweeps, double times, double time) {
  return (1 - discarded_share) * static_cast<double>(sweeps) >= times * time;
}

ChainPlan plan_for(double time, std::uint64_t pilot_sweeps) {
  const auto whole = [](double sweeps) { return static_cast<std::uint64_t>(std::ceil(sweeps)); };
  return {whole(burn_in_times * time), whole(thinning_times * time), time, pilot_sweeps};
}

}  // namespace

ChainPlan plan_chain(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load) {
  const auto too_slow = [&](const std::string& how) {
    return InputError(fmt::format(
        "the chain of the law polytope forgets its past too slowly on {} x {} beads ({}), so that its piles would not "
        "be independent; take a smaller pile, or state burn-in and thinning",
        lattice.columns(), lattice.layers(), how));
  };
  if (lattice.beads() > most_polytope_beads) throw too_slow(fmt::format("more than {} beads", most_polytope_beads));
  Pilot pilot(spec, lattice, load);
  for (std::uint64_t end = fewest_sweeps; end <= most_pilot_sweeps; end *= 2) {
    pilot.run_to(end);
    const double time = pilot.autocorrelation_time();
    if (long_enough(end, pilot_times, time)) return plan_for(time, end);
  }
  throw too_slow(fmt::format("not a hundred times in {} sweeps", most_pilot_sweeps));
}

ChainForecast estimate_chain_time(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load,
                                  double seconds) {
  constexpr std::uint64_t at_once = 16;  // sweeps between two looks at the clock
  ChainForecast forecast;
  Pilot pilot(spec, lattice, load);
  const double start = processor_seconds();
  double sweeping = 0;
  const auto run_to = [&](std::uint64_t end) {
    const double before = processor_seconds();
    do {
      pilot.run_to(std::min(end, pilot.sweeps() + at_once));
    } while (pilot.sweeps() < end && processor_seconds() - start < seconds);
    sweeping += processor_seconds() - before;
  };
  const bool measured = spec.burn_in == 0 || spec.thinning == 0;
  const double expected = shortest_time_expected(spec, lattice);
  // What a pilot has seen often enough stands, even below what is expected.
  const auto expected_at = [&](std::uint64_t sweeps) {
    return long_enough(sweeps, times_of_estimates, expected) ? 0 : expected;
  };
  double time = 0;
  for (std::uint64_t end = fewest_sweeps; end <= most_pilot_sweeps && !forecast.known; end *= 2) {
    run_to(end);
    if (!measured) break;
    time = std::max(pilot.autocorrelation_time(), expected_at(pilot.sweeps()));
    forecast.known = long_enough(pilot.sweeps(), times_of_estimates, time);
    if (processor_seconds() - start >= seconds) break;
  }
  forecast.seconds_per_sweep = sweeping / static_cast<double>(pilot.sweeps());
  forecast.plan = plan_for(time, 0);
  if (measured) {
    std::uint64_t end = fewest_sweeps;
    while (end < most_pilot_sweeps && !long_enough(end, pilot_times, time)) end *= 2;
    forecast.plan.pilot_sweeps = end;
  } else {
    forecast.known = true;
  }
  if (spec.burn_in > 0) forecast.plan.burn_in = spec.burn_in;
  if (spec.thinning > 0) forecast.plan.thinning = spec.thinning;
  return forecast;
}

namespace {

/// The plans of this process. A pilot may take minutes, and the same chain is asked for by an ensemble that grows in
/// steps, by the pictures and by the figures.
class KnownPlans {
 public:
  ChainPlan get(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load) {
    const std::vector<double> key = key_of(spec, lattice, load);
    {
      const std::lock_guard lock(mutex_);
      if (const auto known = outcomes_.find(key); known != outcomes_.end()) return known->second.get();
    }
    Outcome outcome;  // others may go on meanwhile
    try {
      outcome.plan = plan_chain(spec, lattice, load);
    } catch (const InputError& refused) {
      outcome.refusal = refused.what();
    }
    const std::lock_guard lock(mutex_);
    return outcomes_.emplace(key, outcome).first->second.get();
  }

 private:
  /// A plan, or the message of the InputError that stands for none.
  struct Outcome {
    ChainPlan plan;
    std::string refusal;
    const ChainPlan& get() const {
      if (!refusal.empty()) throw InputError(refusal);
      return plan;
    }
  };

  /// All that plan_chain depends on.
  static std::vector<double> key_of(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load) {
    std::vector<double> key = {spec.mu,
                               spec.lambda,
                               spec.effort,
                               static_cast<double>(spec.seed >> 32U),
                               static_cast<double>(spec.seed & 0xffffffffU),
                               static_cast<double>(spec.order),
                               static_cast<double>(lattice.columns()),
                               static_cast<double>(lattice.layers()),
                               spec.load_angle,
                               spec.load_offset,
                               spec.bead_weight};
    key.insert(key.end(), load.begin(), load.end());
    return key;
  }

  std::mutex mutex_;
  std::map<std::vector<double>, Outcome> outcomes_;
};

}  // namespace

SamplerSpec with_measured_chain(SamplerSpec spec, const Lattice& lattice, std::span<const double> load) {
  validate(spec);
  if (spec.law != Law::polytope || spec.mu == 0 || (spec.burn_in > 0 && spec.thinning > 0)) return spec;
  static KnownPlans known;
  const ChainPlan plan = known.get(spec, lattice, load);
  if (spec.burn_in == 0) spec.burn_in = plan.burn_in;
  if (spec.thinning == 0) spec.thinning = plan.thinning;
  return spec;
}

SamplerSpec start_of_chain(const SamplerSpec& spec) {
  const SamplerSpec usual;
  SamplerSpec start = spec;
  start.law = Law::granusolve;
  start.lambda = usual.lambda;
  start.burn_in = usual.burn_in;
  start.thinning = usual.thinning;
  return start;
}

}  // namespace granuscope
