#include "bench/accuracy_suite.h"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <stdexcept>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

#include "analysis/thrust.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/merge.h"
#include "ensemble/parallel.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// The curves add repetitions up as long as so many remain: a scatter of six is known to 30 %.
constexpr int least_repetitions = 6;
constexpr std::uint64_t first_seed = 70'000;
/// Whose linear response the others are held against: of the estimators compared it bends the response least.
constexpr double reference_epsilon = 0.1;
constexpr std::array<double, 3> epsilons{reference_epsilon, 0.25, 0.5};

/// Processor time of this thread, which other programs on the machine do not lengthen.
double thread_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Repetition {
  EnsembleRecord record;
  double seconds = 0;
};

FitSpec bench_fit() {
  FitSpec fit;
  fit.shallow_layer = fit.first_layer;
  // All estimators are to be compared over the same depths, also where the peaks are as narrow as a bead.
  fit.min_identifiable_width = 0.1;
  return fit;
}

Transport measure(const EnsembleSpec& spec, const EnsembleRecord& record) {
  MeasuredEnsemble ensemble;
  ensemble.mu = spec.sampler.mu;
  ensemble.overload = spec.overload;
  ensemble.record = record;
  return measure_transport(ensemble, bench_fit(), {}, 1).transport;
}

struct MeanAndScatter {
  double mean = 0, deviation = 0;
};

MeanAndScatter scatter_of(const std::vector<double>& values) {
  MeanAndScatter result;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / n;
  for (const double value : values) result.deviation += (value - result.mean) * (value - result.mean) / (n - 1);
  result.deviation = std::sqrt(result.deviation);
  return result;
}

Estimate mean_of(const std::vector<double>& values) {
  const MeanAndScatter s = scatter_of(values);
  return {s.mean, s.deviation / std::sqrt(static_cast<double>(values.size())), {}};
}

double distance_from(double reference, const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += (value - reference) * (value - reference);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

/// c, D and c_thrust of every repetition.
struct Values {
  explicit Values(std::size_t repetitions) : c(repetitions), D(repetitions), c_thrust(repetitions) {}
  std::vector<double> c, D, c_thrust;
};

Values fit_all(const EnsembleSpec& spec, const std::vector<Repetition>& repetitions, int threads) {
  Values values(repetitions.size());
  for_each_index(repetitions.size(), threads, [&](std::size_t r) {
    const Transport t = measure(spec, repetitions[r].record);
    values.c[r] = t.c.value;
    values.D[r] = t.D.value;
    values.c_thrust[r] = t.c_thrust.value;
  });
  return values;
}

/// Each two repetitions added up to one.
std::vector<Repetition> paired_up(const std::vector<Repetition>& repetitions) {
  std::vector<Repetition> sums;
  for (std::size_t r = 0; r + 1 < repetitions.size(); r += 2) {
    sums.push_back(repetitions[r]);
    merge_into(sums.back().record, repetitions[r + 1].record);
    sums.back().seconds += repetitions[r + 1].seconds;
  }
  return sums;
}

/// All repetitions of one estimator at one friction coefficient.
struct Drawn {
  EnsembleSpec spec;
  std::vector<Repetition> repetitions;
};

Drawn draw(EnsembleSpec spec, int repetitions, int threads) {
  Drawn drawn{spec, std::vector<Repetition>(static_cast<std::size_t>(repetitions))};
  for_each_index(drawn.repetitions.size(), threads, [&](std::size_t r) {
    EnsembleSpec repetition = spec;
    repetition.sampler.seed = first_seed + r;
    const double start = thread_seconds();
    drawn.repetitions[r].record = run_ensemble(repetition, 1, nullptr);
    drawn.repetitions[r].seconds = thread_seconds() - start;
  });
  return drawn;
}

AccuracyCase summarise(const Drawn& drawn) {
  AccuracyCase result;
  const EnsembleSpec& spec = drawn.spec;
  const bool thrust_only = spec.load == Load::uniform;
  result.mu = spec.sampler.mu;
  result.law = name_of(spec.sampler.law);
  result.estimator = thrust_only ? "thrust" : name_of(spec.estimator);
  if (spec.estimator == EstimatorName::multiplexed) {
    result.epsilon = spec.epsilon;
  } else if (!thrust_only) {
    result.overload = spec.overload;
  }
  result.samples = spec.samples;
  result.repetitions = static_cast<int>(drawn.repetitions.size());
  for (const Repetition& repetition : drawn.repetitions) result.seconds += repetition.seconds / result.repetitions;
  return result;
}

void set_thrust(const std::vector<double>& c_thrust, AccuracyCase& result) {
  result.stderr_c_thrust = scatter_of(c_thrust).deviation;
  result.c_thrust = mean_of(c_thrust);
}

void add_thrust(const Drawn& drawn, AccuracyCase& result) {
  std::vector<double> c_thrust;
  for (const Repetition& r : drawn.repetitions) c_thrust.push_back(measure_thrust(r.record).c_thrust.value);
  set_thrust(c_thrust, result);
}

void add_curve(const Drawn& drawn, double reference_c, double reference_D, int threads, AccuracyCase& result) {
  std::vector<Repetition> repetitions = drawn.repetitions;
  std::uint64_t samples = drawn.spec.samples;
  while (static_cast<int>(repetitions.size()) >= least_repetitions) {
    const Values values = fit_all(drawn.spec, repetitions, threads);
    AccuracyPoint point;
    point.samples = samples;
    point.repetitions = static_cast<int>(repetitions.size());
    for (const Repetition& r : repetitions) point.seconds += r.seconds / point.repetitions;
    point.stderr_c = scatter_of(values.c).deviation;
    point.stderr_D = scatter_of(values.D).deviation;
    point.rms_c = distance_from(reference_c, values.c);
    point.rms_D = distance_from(reference_D, values.D);
    if (result.curve.empty()) {
      result.c = mean_of(values.c);
      result.D = mean_of(values.D);
      set_thrust(values.c_thrust, result);
    }
    result.curve.push_back(point);
    repetitions = paired_up(repetitions);
    samples *= 2;
  }
}

std::vector<EnsembleSpec> specs_at(double mu) {
  EnsembleSpec base;
  base.sampler.mu = mu;
  base.blocks = min_blocks;
  base.layers = layers_to_record(bench_fit(), {});
  EnsembleSpec point = base, paired = base, thrust = base;
  point.samples = 512;
  paired.estimator = EstimatorName::paired;
  paired.samples = 256;
  std::vector<EnsembleSpec> specs{point, paired};
  for (const double epsilon : epsilons) {
    EnsembleSpec multiplexed = base;
    multiplexed.estimator = EstimatorName::multiplexed;
    multiplexed.epsilon = epsilon;
    multiplexed.samples = 128;
    specs.push_back(multiplexed);
  }
  thrust.load = Load::uniform;
  thrust.record_profiles = false;
  thrust.samples = 64;
  specs.push_back(thrust);
  return specs;
}

bool is_multiplexed(const AccuracyCase& c, double epsilon) {
  return c.estimator == "multiplexed" && c.epsilon == epsilon;
}

/// Processor seconds that an error of 1 would cost: errors fall as the square root of the samples.
double cost(double seconds, double error) { return seconds * error * error; }

Speedup speedup_at(const std::vector<AccuracyCase>& cases, double mu, double epsilon) {
  const AccuracyCase *point = nullptr, *multiplexed = nullptr, *thrust = nullptr;
  for (const AccuracyCase& c : cases) {
    if (c.mu != mu) continue;
    if (c.estimator == "point") point = &c;
    if (is_multiplexed(c, epsilon)) multiplexed = &c;
    if (c.estimator == "thrust") thrust = &c;
  }
  if (point == nullptr || multiplexed == nullptr || thrust == nullptr) {
    throw std::logic_error("the accuracy suite did not measure every estimator it compares");
  }
  const AccuracyPoint &p = point->curve.front(), &m = multiplexed->curve.front();
  return {mu, epsilon, cost(p.seconds, p.stderr_D) / cost(m.seconds, m.stderr_D),
          cost(p.seconds, p.stderr_c) / cost(m.seconds, m.stderr_c),
          cost(p.seconds, p.stderr_c) / cost(thrust->seconds, thrust->stderr_c_thrust)};
}

}  // namespace

AccuracyTable measure_accuracy(const AccuracyOptions& options, std::ostream& messages) {
  const int repetitions = options.repetitions;
  AccuracyTable table;
  for (const double mu : {0.1, 0.3}) {
    std::vector<Drawn> drawn;
    for (const EnsembleSpec& spec : specs_at(mu)) {
      drawn.push_back(draw(spec, repetitions, options.threads));
      const AccuracyCase& done = table.cases.emplace_back(summarise(drawn.back()));
      fmt::print(messages, "mu = {}: {} {}, {} x {} piles, {:.3f} s each time\n", mu, done.estimator,
                 done.epsilon > 0 ? fmt::format("epsilon {}", done.epsilon) : "", repetitions, done.samples,
                 done.seconds);
    }
    const std::size_t first = table.cases.size() - drawn.size();
    Transport reference;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      if (!is_multiplexed(table.cases[first + i], reference_epsilon)) continue;
      EnsembleRecord all = drawn[i].repetitions.front().record;
      for (std::size_t r = 1; r < drawn[i].repetitions.size(); ++r) merge_into(all, drawn[i].repetitions[r].record);
      reference = measure(drawn[i].spec, all);
    }
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      if (drawn[i].spec.load == Load::uniform) {
        add_thrust(drawn[i], table.cases[first + i]);
        continue;
      }
      add_curve(drawn[i], reference.c.value, reference.D.value, options.threads, table.cases[first + i]);
    }
    for (const double epsilon : epsilons) table.speedups.push_back(speedup_at(table.cases, mu, epsilon));
  }
  return table;
}

}  // namespace granuscope
