#include <fmt/format.h>

#include <cmath>

#include "bench/accuracy_suite.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

std::string number(double value) { return std::isfinite(value) ? exact(value) : "null"; }

/// Numbers that a case does not have (the thrust alone has no peaks) are null.
std::string number_of(const AccuracyCase& c, double AccuracyPoint::*member) {
  return c.curve.empty() ? "null" : number(c.curve.front().*member);
}

std::string mean_json(const Estimate& mean) {
  if (mean.standard_error == 0 || !mean.known()) return "null";
  return fmt::format(R"({{"value":{},"stderr":{}}})", number(mean.value), number(mean.standard_error));
}

std::string curve_json(const std::vector<AccuracyPoint>& curve) {
  std::string json;
  for (const AccuracyPoint& p : curve) {
    json += fmt::format(
        R"({}{{"samples":{},"seconds":{},"repetitions":{},"stderr_c":{},"stderr_D":{},"rms_c":{},"rms_D":{}}})",
        json.empty() ? "" : ",", p.samples, number(p.seconds), p.repetitions, number(p.stderr_c), number(p.stderr_D),
        number(p.rms_c), number(p.rms_D));
  }
  return json;
}

std::string case_json(const AccuracyCase& c) {
  const auto& [sampler, lattice, response, load, layers, layout, profiles] = c.spec;
  const bool multiplexed = response.estimator == EstimatorName::multiplexed;
  return fmt::format(
      R"({{"mu":{},"law":"{}","estimator":"{}","epsilon":{},"overload":{},"opposite":{},"sign_run":{},"columns":{},)"
      R"("layers":{},"samples":{},"seconds":{},"stderr_c":{},"stderr_D":{},"stderr_c_thrust":{},"repetitions":{},)"
      R"("c":{},"D":{},"c_thrust":{},"slope_c":{},"slope_D":{},"curve":[{}]{}}})",
      number(sampler.mu), name_of(sampler.law), c.thrust_alone() ? "thrust" : name_of(response.estimator),
      multiplexed ? number(response.epsilon) : "null",
      multiplexed || c.thrust_alone() ? "null" : number(response.overload), response.opposite, response.sign_run,
      lattice.columns, lattice.layers, response.samples, number(c.seconds), number_of(c, &AccuracyPoint::stderr_c),
      number_of(c, &AccuracyPoint::stderr_D), number(c.stderr_c_thrust), c.repetitions, mean_json(c.c), mean_json(c.D),
      mean_json(c.c_thrust), mean_json(c.slope_c), mean_json(c.slope_D), curve_json(c.curve),
      c.reason.empty() ? "" : fmt::format(R"(,"reason":"{}")", c.reason));
}

}  // namespace

std::string accuracy_json(const AccuracyTable& table) {
  std::string cases, stated, all;
  for (const AccuracyCase& c : table.cases) cases += (cases.empty() ? "\n  " : ",\n  ") + case_json(c);
  double mu = std::nan("");
  std::size_t at_this_mu = 0;
  for (const Speedup& s : table.speedups) {
    at_this_mu = s.mu == mu ? at_this_mu + 1 : 0;
    mu = s.mu;
    const std::string options = fmt::format(R"("epsilon":{},"opposite":{},"sign_run":{})", number(s.response.epsilon),
                                            s.response.opposite, s.response.sign_run);
    if (at_this_mu == table.stated) {
      stated += fmt::format(R"({}"mu={}":{{"D":{},"c_peaks":{},"c_thrust":{},{}}})", stated.empty() ? "" : ",",
                            exact(s.mu), number(s.D), number(s.c_peaks), number(s.c_thrust), options);
    }
    all += fmt::format(R"({}{{"mu":{},{},"D":{},"c_peaks":{}}})", all.empty() ? "" : ",", exact(s.mu), options,
                       number(s.D), number(s.c_peaks));
  }
  return fmt::format("{{\"cases\":[{}],\n\"speedup_at_equal_error\":{{{}}},\n\"speedup_by_options\":[{}]}}\n", cases,
                     stated, all);
}

}  // namespace granuscope
