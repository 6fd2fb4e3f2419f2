#include "analysis/nonlinearity.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/layer_spectrum.h"
#include "analysis/power_law.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr double window_slack = 1e-9;  ///< both ends of [0.1, 0.3] are inside

double logarithm(double number) { return std::log(number); }
double log_of_slowing(double c) { return std::log(tan30 - c); }

bool is_uniform(const MeasuredEnsemble& ensemble) { return ensemble.estimator == uniform_load; }

/// The speed that follows from the thrust ratio over the layers of the window, with replicates.
Replicated thrust_speed(const BlockSums& sums, int first_layer) {
  std::vector<Replicated> ratios;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    if (sums.layers[row] >= first_layer) ratios.push_back(block_mean(sums, "thrust", row));
  }
  return transform([](double alpha) { return tan30 * std::sqrt(alpha); }, mean_of(ratios));
}

bool has_empty_block(const BlockSums& sums) {
  return std::find(sums.count.begin(), sums.count.end(), 0) != sums.count.end();
}

Replicated difference(const Replicated& one, const Replicated& other) {
  return transform([](double a, double b) { return a - b; }, one, other);
}

Estimate unknown_because(const std::string& reason) {
  Estimate unknown;
  unknown.reason = reason;
  return unknown;
}

/// f(one, reference), or why it is unknown.
template <typename F>
Estimate compare(const Estimate& one, const Replicated& replicates, const Estimate& reference,
                 const Replicated& reference_replicates, F f) {
  if (!one.known()) return unknown_because(one.reason);
  if (!reference.known()) return unknown_because("the linear response is unknown here: " + reference.reason);
  return estimate(transform(f, replicates, reference_replicates));
}

}  // namespace

void NonlinearityMeasurer::add(MeasuredEnsemble ensemble) {
  if (!open_.empty() && open_.front().mu != ensemble.mu) close_friction();
  open_.push_back(std::move(ensemble));
}

NonlinearityMeasurer::Measured NonlinearityMeasurer::measure(const MeasuredEnsemble& ensemble,
                                                             const FitSpec& fit) const {
  Measured measured;
  LoadResponse& response = measured.response;
  const BlockSums& sums = ensemble.record.sums;
  response.mu = ensemble.mu;
  response.estimator = ensemble.estimator;
  const bool multiplexed = ensemble.estimator == "multiplexed";
  response.load = is_uniform(ensemble) ? 0 : multiplexed ? ensemble.epsilon : ensemble.overload;
  response.reference = multiplexed && ensemble.epsilon == reference_epsilon_;
  response.columns = ensemble.lattice.columns;
  response.layers = ensemble.lattice.layers;
  response.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  response.failed = ensemble.record.failed.size();
  response.first_layer = fit.first_layer;
  response.last_layer = fit.last_layer;
  if (is_uniform(ensemble)) {
    response.c.reason = response.D.reason = "a uniform load has no response";
    return measured;
  }
  const MeasuredTransport transport = measure_transport(ensemble, fit, {}, threads_);
  response.c = transport.transport.c;
  response.D = transport.transport.D;
  response.first_layer = transport.transport.window_layers[0];
  measured.c = transport.c;
  measured.D = transport.D;
  return measured;
}

void NonlinearityMeasurer::close_friction() {
  std::vector<Measured> measured;
  for (const MeasuredEnsemble& ensemble : open_) measured.push_back(measure(ensemble, fit_));
  // The slopes of all loads over the same layers: those where all of them can be fitted.
  FitSpec common = fit_;
  for (const Measured& one : measured) {
    if (one.response.c.known()) common.first_layer = std::max(common.first_layer, one.response.first_layer);
  }
  const Replicated* uniform = nullptr;
  std::vector<Replicated> speeds;
  for (std::size_t k = 0; k < open_.size(); ++k) {
    LoadResponse& response = measured[k].response;
    if (response.c.known() && response.first_layer != common.first_layer) measured[k] = measure(open_[k], common);
    response.first_layer = common.first_layer;
    const BlockSums& sums = open_[k].record.sums;
    if (has_empty_block(sums)) {
      speeds.push_back({std::nan(""), std::vector<double>(sums.count.size(), std::nan(""))});
    } else {
      speeds.push_back(thrust_speed(sums, common.first_layer));
    }
    response.c_thrust = estimate(speeds.back(), "a block of the ensemble holds no completed pile");
  }
  const Measured* reference = nullptr;
  for (std::size_t k = 0; k < open_.size(); ++k) {
    if (measured[k].response.reference) reference = &measured[k];
    if (is_uniform(open_[k]) && measured[k].response.c_thrust.known()) uniform = &speeds[k];
  }
  const Measured none;
  const Measured& linear = reference == nullptr ? none : *reference;
  for (std::size_t k = 0; k < open_.size(); ++k) {
    LoadResponse& response = measured[k].response;
    response.c_shift = compare(response.c, measured[k].c, linear.response.c, linear.c,
                               [](double c, double of_linear) { return c - of_linear; });
    response.D_shift = compare(response.D, measured[k].D, linear.response.D, linear.D,
                               [](double D, double of_linear) { return D / of_linear - 1; });
    response.c_thrust_shift = uniform == nullptr || !response.c_thrust.known()
                                  ? unknown_because("no thrust ratio is known to compare with")
                                  : estimate(difference(speeds[k], *uniform));
  }
  measured_.push_back(std::move(measured));
  open_.clear();
}

/// The exponents of one load, over the friction coefficients given.
struct NonlinearityMeasurer::LawPair {
  ReplicatedPowerLaw beta, gamma;

  LawPair(const std::vector<const Measured*>& points, std::array<double, 2> window) {
    std::vector<Replicated> log_mu, log_D, log_slowing;
    for (const Measured* one : points) {
      log_mu.push_back(transform([&](double) { return std::log(one->response.mu); }, one->D));
      log_D.push_back(transform(logarithm, one->D));
      log_slowing.push_back(transform(log_of_slowing, one->c));
    }
    beta = fit_replicated_power_law(log_mu, log_D, window);
    gamma = fit_replicated_power_law(log_mu, log_slowing, window);
  }
};

bool NonlinearityMeasurer::has_logarithms(const Measured& one) {
  return one.response.c.known() && one.response.D.known() && estimate(transform(logarithm, one.D)).known() &&
         estimate(transform(log_of_slowing, one.c)).known();
}

/// The exponents of the load number `k` of every friction coefficient, and how they differ from those of the linear
/// response over the same friction coefficients: exponents over different ones could not be compared.
LoadExponents NonlinearityMeasurer::measure_exponents(std::size_t k) const {
  const std::array<double, 2> window = fit_.scaling_window;
  std::vector<const Measured*> points, linear_points;
  for (const std::vector<Measured>& loads : measured_) {
    const double mu = loads.front().response.mu;
    if (mu < window[0] - window_slack || mu > window[1] + window_slack || !has_logarithms(loads[k])) continue;
    const auto linear =
        std::find_if(loads.begin(), loads.end(), [](const Measured& one) { return one.response.reference; });
    if (linear == loads.end() || !has_logarithms(*linear)) continue;
    points.push_back(&loads[k]);
    linear_points.push_back(&*linear);
  }
  const LawPair laws(points, window), linear(linear_points, window);
  const LoadResponse& load = measured_.front()[k].response;
  LoadExponents exponents;
  exponents.estimator = load.estimator;
  exponents.load = load.load;
  exponents.reference = load.reference;
  exponents.window = {points.empty() ? window[0] : points.front()->response.mu,
                      points.empty() ? window[1] : points.back()->response.mu};
  exponents.points = static_cast<int>(points.size());
  exponents.beta = laws.beta.fit.exponent;
  exponents.gamma = laws.gamma.fit.exponent;
  const auto shift = [](const ReplicatedPowerLaw& one, const ReplicatedPowerLaw& of_linear) {
    return compare(one.fit.exponent, one.exponent, of_linear.fit.exponent, of_linear.exponent,
                   [](double a, double b) { return a - b; });
  };
  exponents.beta_shift = shift(laws.beta, linear.beta);
  exponents.gamma_shift = shift(laws.gamma, linear.gamma);
  return exponents;
}

Nonlinearity NonlinearityMeasurer::finish() {
  if (!open_.empty()) close_friction();
  Nonlinearity result;
  for (const std::vector<Measured>& loads : measured_) {
    for (const Measured& one : loads) result.responses.push_back(one.response);
  }
  if (measured_.empty()) return result;
  for (std::size_t k = 0; k < measured_.front().size(); ++k) {
    if (measured_.front()[k].response.estimator != uniform_load) result.exponents.push_back(measure_exponents(k));
  }
  return result;
}

}  // namespace granuscope
