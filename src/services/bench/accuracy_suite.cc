#include "bench/suites.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "plot/figure_captions.h"
#include "report/clean_json.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
/// The multiplexed estimators compared. With one epsilon, opposite loads and runs change the scatter and not what is
/// measured, but for what is of the order epsilon^2. The linear response that the others are held against (set_shifts)
/// is the first one of opposite loads: of those compared it bends the response least.
std::vector<ResponseSpec> multiplexings() {
  return {multiplexed_response(0.1),         multiplexed_response(0.25),       multiplexed_response(0.5),
          multiplexed_response(0.1, true),   multiplexed_response(0.25, true), multiplexed_response(0.25, true, 2),
          multiplexed_response(0.5, true, 2)};
}

/// Those of them that are measured everywhere: the best ones at small friction and at larger one.
std::vector<ResponseSpec> best_multiplexings() {
  return {multiplexed_response(0.25, true), multiplexed_response(0.25, true, 2)};
}

/// The speed-up stated first is that of the linear response without any bias.
bool is_stated(const ResponseSpec& response) { return response.estimator == EstimatorName::fluctuation; }

/// As deep as pays, and just wide enough for two peaks.
constexpr LatticeSpec unloaded_piles{256, 1600};
/// Denser bases cost time and make no error smaller: their waves are the same.
constexpr ResponseSpec unloaded_response{.estimator = EstimatorName::fluctuation, .base_step = 24};

/// The depths that a run fits by default, also where the peaks are as narrow as a bead: the same for all estimators.
FitSpec bench_fit() {
  FitSpec fit;
  fit.shallow_layer = fit.first_layer;
  fit.min_identifiable_width = least_identifiable_width;
  return fit;
}

/// A law that is good for small piles only, and the largest it is asked for here.
struct SmallLaw {
  Law law;
  LatticeSpec lattice;
  const char* reason;
};
constexpr SmallLaw small_laws[] = {
    {Law::eloy_clement,
     {6, 6},
     "the cost of this law grows exponentially with the pile: peaks stand apart only in piles that it never completes"},
    {Law::rejection,
     {6, 6},
     "this law throws a whole pile away for one failing bead: piles in which peaks stand apart are never completed"},
    {Law::polytope,
     {8, 12},
     "the chain of this law forgets its past more slowly the larger the pile: peaks stand apart only in piles that it "
     "would sample for hours"}};

/// Processor time of all threads so far.
double seconds_of_all_threads() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// `spec`: of one repetition. `no_peaks`: why there is no scatter of c and D of the peaks; empty where there is one.
AccuracyCase measure(EnsembleSpec spec, const std::string& no_peaks, const AccuracyOptions& options,
                     std::ostream& messages) {
  const std::uint64_t samples = spec.response.samples;
  spec.response.samples *= static_cast<std::uint64_t>(options.repetitions);
  spec.response.blocks = repetition_blocks * options.repetitions;
  spec.sampler = measured_sampler(spec);  // the length of a chain is known before the clock starts
  AccuracyCase done;
  const double start = seconds_of_all_threads();
  const auto before = std::chrono::steady_clock::now();
  const MeasuredEnsemble ensemble{spec, run_ensemble(spec, options.threads, nullptr)};
  done.seconds = seconds_of_all_threads() - start;
  done.wall = options.threads * std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  fmt::print(messages, "mu = {}: {}, {} on {} x {} beads, {} x {} samples, {:.3f} s each time{}\n", spec.sampler.mu,
             name_of(spec.sampler.law), spec.load == Load::uniform ? "thrust" : in_words(spec.response),
             spec.lattice.columns, spec.lattice.layers, options.repetitions, samples,
             done.seconds / options.repetitions, no_peaks.empty() ? "" : "; no peaks: " + no_peaks);
  done.c_thrust = estimate(thrust_speed(ensemble.record.sums, 1), "a block of the ensemble holds no completed pile");
  if (no_peaks.empty()) {
    done.curve = measure_error_curve(ensemble, bench_fit(), options.threads);
    return done;
  }
  done.curve.spec = spec;
  for (Estimate* unknown : {&done.curve.c, &done.curve.D, &done.curve.slope_c, &done.curve.slope_D}) {
    unknown->reason = no_peaks;
  }
  return done;
}

/// Processor seconds that an error of 1 would cost: errors fall as the square root of the samples.
double cost(const AccuracyCase& c, const Estimate& number) {
  return c.seconds * number.standard_error * number.standard_error;
}

/// `all`: of the estimators, and not only the best.
void measure_peaks(double mu, bool all, const AccuracyOptions& options, std::ostream& messages, AccuracyTable& table) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.layers = layers_to_record(bench_fit(), {});
  std::vector<AccuracyCase> cases;
  const auto add = [&](const ResponseSpec& response, std::uint64_t samples, const std::string& no_peaks = {}) {
    spec.response = response;
    spec.response.samples = samples;
    cases.push_back(measure(spec, no_peaks, options, messages));
  };
  add({}, 256);
  if (all) add({.estimator = EstimatorName::paired}, 256);
  const std::size_t first_compared = cases.size();
  add({.overloads = 0, .coupled = true}, 256);
  for (const ResponseSpec& response : all ? multiplexings() : best_multiplexings()) add(response, 256);
  const LatticeSpec loaded_piles = std::exchange(spec.lattice, unloaded_piles);
  add(unloaded_response, 64);
  spec.lattice = loaded_piles;
  spec.load = Load::uniform;
  spec.record_profiles = false;
  add({}, 64, "a uniform load has no response");

  std::vector<ErrorCurve> curves;
  curves.reserve(cases.size());
  for (const AccuracyCase& c : cases) curves.push_back(c.curve);
  set_shifts(curves);
  for (std::size_t k = 0; k < cases.size(); ++k) cases[k].curve = curves[k];

  const AccuracyCase &point = cases.front(), &thrust = cases.back();
  const double of_c = cost(point, point.curve.c), of_D = cost(point, point.curve.D);
  for (std::size_t k = first_compared; k + 1 < cases.size(); ++k) {
    const AccuracyCase& c = cases[k];
    const ResponseSpec& response = c.curve.spec.response;
    table.speedups.push_back({mu, response, of_D / cost(c, c.curve.D), of_c / cost(c, c.curve.c),
                              of_c / cost(thrust, thrust.c_thrust), is_stated(response)});
  }
  table.cases.insert(table.cases.end(), cases.begin(), cases.end());
}

/// Every estimator with the laws of small piles, by the thrust ratio over all layers but the top one.
void measure_small_laws(double mu, const AccuracyOptions& options, std::ostream& messages, AccuracyTable& table) {
  for (const SmallLaw& small : small_laws) {
    for (const EstimatorName estimator : {EstimatorName::point, EstimatorName::paired, EstimatorName::multiplexed}) {
      EnsembleSpec spec;
      spec.sampler.mu = mu;
      spec.sampler.law = small.law;
      spec.sampler.effort = 1e5;
      spec.lattice = small.lattice;
      spec.response.estimator = estimator;
      spec.response.samples = group_size * repetition_blocks;
      table.cases.push_back(measure(spec, small.reason, options, messages));
    }
  }
}

Json case_json(const AccuracyCase& c) {
  const auto& [curve, seconds, wall, c_thrust] = c;
  const int repetitions = c.repetitions();
  const auto of_one = [&](const Estimate& number) {
    return finite_or_null(number.standard_error * std::sqrt(repetitions));
  };
  const auto rms = [](double scatter, const Estimate& shift) {
    return finite_or_null(std::hypot(scatter, shift.known() ? shift.value : 0));
  };
  const double samples = static_cast<double>(curve.spec.response.samples) / repetitions;
  Json json = {{"mu", curve.spec.sampler.mu},
               {"law", name_of(curve.spec.sampler.law)},
               {"columns", curve.spec.lattice.columns},
               {"layers", curve.spec.lattice.layers}};
  json.update(Json(curve.spec.response));
  if (c.thrust_alone()) json["estimator"] = "thrust";
  json.update(Json{{"samples", samples},
                   {"seconds", seconds / repetitions},
                   {"wall_seconds", wall / repetitions},
                   {"repetitions", repetitions},
                   {"stderr_c", of_one(curve.c)},
                   {"stderr_D", of_one(curve.D)},
                   {"stderr_c_thrust", of_one(c_thrust)},
                   {"c", curve.c},
                   {"D", curve.D},
                   {"c_thrust", c_thrust},
                   {"slope_c", curve.slope_c},
                   {"slope_D", curve.slope_D}});
  json["curve"] = Json::array();
  for (const ErrorPoint& p : curve.points) {
    json["curve"].push_back({{"samples", p.samples},
                             {"seconds", seconds / repetitions * static_cast<double>(p.samples) / samples},
                             {"repetitions", p.repetitions},
                             {"stderr_c", p.scatter_c},
                             {"stderr_D", p.scatter_D},
                             {"rms_c", rms(p.scatter_c, curve.shift_c)},
                             {"rms_D", rms(p.scatter_D, curve.shift_D)}});
  }
  return json;
}

}  // namespace

AccuracyTable measure_accuracy(const AccuracyOptions& options, std::ostream& messages) {
  AccuracyTable table;
  for (const double mu : {0.1, 0.15, 0.2, 0.3, 0.4}) {
    const bool main = mu == 0.1 || mu == 0.3, all = main && !options.quick;
    if (main || !options.quick) measure_peaks(mu, all, options, messages, table);
    if (all) measure_small_laws(mu, options, messages, table);
  }
  return table;
}

std::string accuracy_json(const AccuracyTable& table) {
  Json json;
  for (const AccuracyCase& c : table.cases) json["cases"].push_back(case_json(c));
  for (const Speedup& s : table.speedups) {
    Json speedup = {{"mu", s.mu},
                    {"D", finite_or_null(s.D)},
                    {"c_peaks", finite_or_null(s.c_peaks)},
                    {"c_thrust", finite_or_null(s.c_thrust)}};
    speedup.update(Json(s.response));
    if (s.stated) json["speedup_at_equal_error"]["mu=" + exact(s.mu)] = speedup;
    json["speedup_by_options"].push_back(speedup);
  }
  return json.dump(1) + "\n";
}

}  // namespace granuscope
