#include "bench/accuracy_suite.h"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <stdexcept>

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/error_curve.h"
#include "analysis/transport.h"
#include "bench/thrust.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/merge.h"
#include "ensemble/parallel.h"
#include "plot/response_in_words.h"
#include "sampling/chain_plan.h"
#include "support/number_format.h"
#include "support/processor_time.h"

namespace granuscope {
namespace {

/// The curves add repetitions up as long as so many remain: a scatter of six is known to 30 %.
constexpr int least_repetitions = 6;
constexpr std::uint64_t first_seed = 70'000;

/// The multiplexed estimators compared. With one epsilon, opposite loads and runs change the scatter and not what is
/// measured, but for what is of the order epsilon^2.
const std::array<ResponseSpec, 7>& multiplexings() {
  static const std::array<ResponseSpec, 7> all{multiplexed_response(0.1),         multiplexed_response(0.25),
                                               multiplexed_response(0.5),         multiplexed_response(0.1, true),
                                               multiplexed_response(0.25, true),  multiplexed_response(0.25, true, 2),
                                               multiplexed_response(0.5, true, 2)};
  return all;
}
/// Whose linear response the others are held against: of those compared it bends the response least, and scatters less
/// than the other one of its epsilon.
constexpr std::size_t reference_multiplexing = 3;
/// The speed-up stated first is that of the linear response: of the epsilon whose bias is below the scatter.
constexpr std::size_t stated_multiplexing = 5;

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
  return measure_transport({spec, record}, bench_fit(), {}, 1, BiasedPairs::measured).transport;
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
    const double start = processor_seconds();
    drawn.repetitions[r].record = run_ensemble(repetition, 1, nullptr);
    drawn.repetitions[r].seconds = processor_seconds() - start;
  });
  return drawn;
}

AccuracyCase summarise(const Drawn& drawn) {
  AccuracyCase result;
  result.spec = drawn.spec;
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
  std::uint64_t samples = drawn.spec.response.samples;
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
      const auto without = std::count_if(values.D.begin(), values.D.end(), [](double D) { return !std::isfinite(D); });
      if (without > 0) {
        result.reason = fmt::format("{} of {} repetitions of {} samples have no fit of two peaks", without,
                                    point.repetitions, samples);
      }
    }
    result.curve.push_back(point);
    repetitions = paired_up(repetitions);
    samples *= 2;
  }
  std::vector<ErrorPoint> points;
  for (const AccuracyPoint& p : result.curve) points.push_back({p.samples, p.repetitions, p.stderr_c, p.stderr_D});
  result.slope_c = slope_of_scatter(points, &ErrorPoint::scatter_c);
  result.slope_D = slope_of_scatter(points, &ErrorPoint::scatter_D);
}

std::vector<EnsembleSpec> specs_at(double mu) {
  EnsembleSpec base;
  base.sampler.mu = mu;
  base.response.blocks = min_blocks;
  base.layers = layers_to_record(bench_fit(), {});
  EnsembleSpec point = base, paired = base, thrust = base;
  point.response.samples = 1024;
  paired.response.estimator = EstimatorName::paired;
  paired.response.samples = 256;
  std::vector<EnsembleSpec> specs{point, paired};
  for (const ResponseSpec& options : multiplexings()) {
    EnsembleSpec multiplexed = base;
    multiplexed.response = options;
    multiplexed.response.blocks = base.response.blocks;
    multiplexed.response.samples = 256;
    specs.push_back(multiplexed);
  }
  thrust.load = Load::uniform;
  thrust.record_profiles = false;
  thrust.response.samples = 64;
  specs.push_back(thrust);
  return specs;
}

bool is_multiplexed(const AccuracyCase& c, const ResponseSpec& options) {
  return in_words(c.spec.response) == in_words(options);
}

/// Processor seconds that an error of 1 would cost: errors fall as the square root of the samples.
double cost(double seconds, double error) { return seconds * error * error; }

Speedup speedup_at(const std::vector<AccuracyCase>& cases, double mu, const ResponseSpec& options) {
  const AccuracyCase *point = nullptr, *multiplexed = nullptr, *thrust = nullptr;
  for (const AccuracyCase& c : cases) {
    if (c.spec.sampler.mu != mu || c.spec.sampler.law != Law::granusolve) continue;
    if (c.thrust_alone()) {
      thrust = &c;
    } else if (c.spec.response.estimator == EstimatorName::point) {
      point = &c;
    }
    if (is_multiplexed(c, options)) multiplexed = &c;
  }
  if (point == nullptr || multiplexed == nullptr || thrust == nullptr) {
    throw std::logic_error("the accuracy suite did not measure every estimator it compares");
  }
  const AccuracyPoint &p = point->curve.front(), &m = multiplexed->curve.front();
  return {mu, options, cost(p.seconds, p.stderr_D) / cost(m.seconds, m.stderr_D),
          cost(p.seconds, p.stderr_c) / cost(m.seconds, m.stderr_c),
          cost(p.seconds, p.stderr_c) / cost(thrust->seconds, thrust->stderr_c_thrust)};
}

/// A law that is good for small piles only, and the largest it is asked for here.
struct SmallLaw {
  Law law;
  LatticeSpec lattice;
  const char* reason;
};
constexpr std::array<SmallLaw, 3> small_laws{
    {{Law::eloy_clement,
      {6, 6},
      "the cost of this law grows exponentially with the pile: peaks stand apart only in piles that it never "
      "completes"},
     {Law::rejection,
      {6, 6},
      "this law throws a whole pile away for one failing bead: piles in which peaks stand apart are never completed"},
     {Law::polytope,
      {8, 12},
      "the chain of this law forgets its past more slowly the larger the pile: peaks stand apart only in piles that it "
      "would sample for hours"}}};

/// Every estimator with the laws of small piles, by the scatter of the thrust ratio over all layers but the top one.
void add_other_laws(double mu, const AccuracyOptions& options, std::ostream& messages, AccuracyTable& table) {
  for (const SmallLaw& small : small_laws) {
    for (const EstimatorName estimator : {EstimatorName::point, EstimatorName::paired, EstimatorName::multiplexed}) {
      EnsembleSpec spec;
      spec.sampler.mu = mu;
      spec.sampler.law = small.law;
      spec.sampler.seed = first_seed;
      spec.sampler.effort = 1e5;
      spec.lattice = small.lattice;
      spec.response.estimator = estimator;
      spec.response.blocks = min_blocks;
      spec.response.samples = group_size * min_blocks;
      for (int layer = 1; layer < small.lattice.layers; ++layer) spec.layers.push_back(layer);
      // The length of the chains is measured once, not by every repetition.
      spec.sampler = with_measured_chain(spec.sampler, Lattice(spec.lattice), top_load(spec));
      const Drawn drawn = draw(spec, options.repetitions, options.threads);
      AccuracyCase& done = table.cases.emplace_back(summarise(drawn));
      add_thrust(drawn, done);
      done.reason = small.reason;
      fmt::print(messages, "mu = {}: {}, {} on {} x {} beads, {} x {} piles, {:.3f} s each time; no peaks: {}\n", mu,
                 name_of(small.law), name_of(estimator), small.lattice.columns, small.lattice.layers,
                 options.repetitions, spec.response.samples, done.seconds, done.reason);
    }
  }
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
      fmt::print(messages, "mu = {}: {}, {}, {} x {} samples, {:.3f} s each time\n", mu, name_of(spec.sampler.law),
                 done.thrust_alone() ? "thrust" : in_words(spec.response), repetitions, spec.response.samples,
                 done.seconds);
    }
    const std::size_t first = table.cases.size() - drawn.size();
    Transport linear;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      if (!is_multiplexed(table.cases[first + i], multiplexings()[reference_multiplexing])) continue;
      EnsembleRecord all = drawn[i].repetitions.front().record;
      for (std::size_t r = 1; r < drawn[i].repetitions.size(); ++r) merge_into(all, drawn[i].repetitions[r].record);
      linear = measure(drawn[i].spec, all);
    }
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      if (drawn[i].spec.load == Load::uniform) {
        add_thrust(drawn[i], table.cases[first + i]);
        continue;
      }
      add_curve(drawn[i], linear.c.value, linear.D.value, options.threads, table.cases[first + i]);
    }
    add_other_laws(mu, options, messages, table);
    for (const ResponseSpec& options_compared : multiplexings()) {
      table.speedups.push_back(speedup_at(table.cases, mu, options_compared));
    }
    table.stated = stated_multiplexing;
  }
  return table;
}

}  // namespace granuscope
