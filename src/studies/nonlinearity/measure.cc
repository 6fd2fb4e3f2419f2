#include "measure.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/layer_spectrum.h"
#include "analysis/power_law.h"
#include "analysis/transport.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr double window_slack = 1e-9;  ///< both ends of [0.1, 0.3] are inside

double logarithm(double number) { return std::log(number); }
double log_of_slowing(double c) { return std::log(tan30 - c); }

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

/// f(one, of_linear), or why it is unknown.
template <typename F>
Estimate compare(const Estimate& one, const Replicated& replicates, const Estimate& of_linear,
                 const Replicated& linear_replicates, F f) {
  if (!one.known()) return unknown_because(one.reason);
  if (!of_linear.known()) return unknown_because("the linear response is unknown here: " + of_linear.reason);
  return estimate(transform(f, replicates, linear_replicates));
}

}  // namespace

void LoadComparer::add(MeasuredEnsemble ensemble) {
  if (!open_.empty() && open_.front().spec.sampler.mu != ensemble.spec.sampler.mu) close_friction();
  open_.push_back(std::move(ensemble));
}

LoadComparer::Measured LoadComparer::measure(const MeasuredEnsemble& ensemble, const FitSpec& fit) const {
  Measured measured;
  LoadResponse& response = measured.response;
  const BlockSums& sums = ensemble.record.sums;
  response.spec = ensemble.spec;
  const ResponseSpec& load = ensemble.spec.response;
  response.reference = load.estimator == EstimatorName::multiplexed && load.epsilon == reference_epsilon_;
  response.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  response.failed = ensemble.record.failed.size();
  response.first_layer = fit.first_layer;
  response.last_layer = fit.last_layer;
  if (response.uniform()) {
    response.c.reason = response.D.reason = "a uniform load has no response";
    measured.slopes = {{response.c, {}}, {response.D, {}}};
    return measured;
  }
  const MeasuredTransport transport = measure_transport(ensemble, fit, {}, threads_);
  response.c = transport.transport.c;
  response.D = transport.transport.D;
  response.first_layer = transport.transport.window_layers[0];
  measured.depths = transport.transport.depths_in_window;
  measured.slopes = {{response.c, transport.c}, {response.D, transport.D}};
  return measured;
}

FitSpec LoadComparer::starting_at(int first_layer) const {
  FitSpec fit = fit_;
  fit.first_layer = first_layer;
  return fit;
}

/// Where the runs of all loads overlap that can be fitted at enough of the depths of the linear response.
int LoadComparer::first_common_layer(const std::vector<Measured>& measured) const {
  int enough = 0;
  for (const Measured& one : measured) {
    if (one.response.reference) enough = static_cast<int>(std::ceil(common_share * one.depths));
  }
  int first = fit_.first_layer;
  for (const Measured& one : measured) {
    if (one.response.c.known() && one.depths >= enough) first = std::max(first, one.response.first_layer);
  }
  return first;
}

void LoadComparer::close_friction() {
  std::vector<Measured> measured;
  for (const MeasuredEnsemble& ensemble : open_) measured.push_back(measure(ensemble, fit_));
  const int common = first_common_layer(measured);
  const Replicated* uniform = nullptr;
  std::vector<Replicated> speeds;
  const MeasuredEnsemble* linear_ensemble = nullptr;
  for (std::size_t k = 0; k < open_.size(); ++k) {
    LoadResponse& response = measured[k].response;
    response.own_window = response.c.known() && response.first_layer > common;
    if (response.c.known() && response.first_layer < common) measured[k] = measure(open_[k], starting_at(common));
    if (!measured[k].response.own_window) measured[k].response.first_layer = common;
    if (measured[k].response.reference) linear_ensemble = &open_[k];
    const BlockSums& sums = open_[k].record.sums;
    if (has_empty_block(sums)) {
      speeds.push_back({std::nan(""), std::vector<double>(sums.count.size(), std::nan(""))});
    } else {
      speeds.push_back(thrust_speed(sums, common));
    }
    measured[k].response.c_thrust = estimate(speeds.back(), "a block of the ensemble holds no completed pile");
  }
  Slopes linear;
  linear.c.estimate.reason = linear.D.estimate.reason = "no such ensemble was drawn";
  for (std::size_t k = 0; k < open_.size(); ++k) {
    if (measured[k].response.reference) linear = measured[k].slopes;
    if (measured[k].response.uniform() && measured[k].response.c_thrust.known()) uniform = &speeds[k];
  }
  for (std::size_t k = 0; k < open_.size(); ++k) {
    Measured& one = measured[k];
    LoadResponse& response = one.response;
    one.linear = response.own_window && linear_ensemble != nullptr
                     ? measure(*linear_ensemble, starting_at(response.first_layer)).slopes
                     : linear;
    response.c_shift = compare(one.slopes.c.estimate, one.slopes.c.replicates, one.linear.c.estimate,
                               one.linear.c.replicates, [](double c, double of_linear) { return c - of_linear; });
    response.D_shift = compare(one.slopes.D.estimate, one.slopes.D.replicates, one.linear.D.estimate,
                               one.linear.D.replicates, [](double D, double of_linear) { return D / of_linear - 1; });
    response.c_thrust_shift = uniform == nullptr || !response.c_thrust.known()
                                  ? unknown_because("no thrust ratio is known to compare with")
                                  : estimate(difference(speeds[k], *uniform));
  }
  measured_.push_back(std::move(measured));
  open_.clear();
}

/// The exponents of one load, over the friction coefficients given.
struct LoadComparer::LawPair {
  ReplicatedPowerLaw beta, gamma;

  LawPair(const std::vector<double>& mu, const std::vector<const Slopes*>& points, std::array<double, 2> window) {
    std::vector<Replicated> log_mu, log_D, log_slowing;
    for (std::size_t i = 0; i < points.size(); ++i) {
      log_mu.push_back(transform([&](double) { return std::log(mu[i]); }, points[i]->D.replicates));
      log_D.push_back(transform(logarithm, points[i]->D.replicates));
      log_slowing.push_back(transform(log_of_slowing, points[i]->c.replicates));
    }
    beta = fit_replicated_power_law(log_mu, log_D, window);
    gamma = fit_replicated_power_law(log_mu, log_slowing, window);
  }
};

bool LoadComparer::has_logarithms(const Slopes& slopes) {
  return slopes.c.estimate.known() && slopes.D.estimate.known() &&
         estimate(transform(logarithm, slopes.D.replicates)).known() &&
         estimate(transform(log_of_slowing, slopes.c.replicates)).known();
}

/// The exponents of the load number `k` of every friction coefficient, and how they differ from those of the linear
/// response over the same friction coefficients and layers: others could not be compared.
LoadExponents LoadComparer::measure_exponents(std::size_t k) const {
  const std::array<double, 2> window = fit_.scaling_window;
  std::vector<double> at_mu;
  std::vector<const Slopes*> points, linear_points;
  for (const std::vector<Measured>& loads : measured_) {
    const Measured& one = loads[k];
    const double mu = one.response.spec.sampler.mu;
    if (mu < window[0] - window_slack || mu > window[1] + window_slack) continue;
    if (!has_logarithms(one.slopes) || !has_logarithms(one.linear)) continue;
    at_mu.push_back(mu);
    points.push_back(&one.slopes);
    linear_points.push_back(&one.linear);
  }
  const LawPair laws(at_mu, points, window), linear(at_mu, linear_points, window);
  const LoadResponse& load = measured_.front()[k].response;
  LoadExponents exponents;
  exponents.response = load.spec.response;
  exponents.reference = load.reference;
  exponents.window = {at_mu.empty() ? window[0] : at_mu.front(), at_mu.empty() ? window[1] : at_mu.back()};
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

LoadComparison LoadComparer::finish() {
  if (!open_.empty()) close_friction();
  LoadComparison result;
  for (const std::vector<Measured>& loads : measured_) {
    for (const Measured& one : loads) result.responses.push_back(one.response);
  }
  if (measured_.empty()) return result;
  for (std::size_t k = 0; k < measured_.front().size(); ++k) {
    if (!measured_.front()[k].response.uniform()) result.exponents.push_back(measure_exponents(k));
  }
  return result;
}

}  // namespace granuscope
