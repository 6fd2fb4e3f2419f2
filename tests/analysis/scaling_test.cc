#include "analysis/scaling.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/claims.h"
#include "kit/claim.h"
#include "kit/estimates.h"
#include "model/lattice.h"

using namespace granuscope;
using test::claim;

namespace {

/// A transport whose D and c0 - c follow power laws of mu, with small replicate scatter of a given relative size.
MeasuredTransport on_power_laws(double mu, double beta, double gamma, double scatter) {
  MeasuredTransport result;
  result.transport.spec.sampler.mu = mu;
  const double D = 1.6 * std::pow(mu, beta), slowing = 0.15 * std::pow(mu, gamma);
  result.D.value = D;
  result.c.value = tan30 - slowing;
  for (int b = 0; b < 16; ++b) {
    const double sign = (b % 2 == 0 ? 1 : -1) * scatter * (1 + mu);
    result.D.without_block.push_back(D * (1 + sign));
    result.c.without_block.push_back(tan30 - slowing * (1 + (b % 4 < 2 ? 1 : -1) * scatter));
  }
  result.transport.D = estimate(result.D);
  result.transport.c = estimate(result.c);
  return result;
}

std::vector<MeasuredTransport> family(double scatter) {
  std::vector<MeasuredTransport> all;
  for (double mu : {0.05, 0.1, 0.2, 0.3, 0.6}) all.push_back(on_power_laws(mu, 2.5, 1.7, scatter));
  return all;
}

ScalingFit exponent(double value, double error) {
  ScalingFit fit;
  fit.exponent = test::known(value, error);
  fit.window = {0.1, 0.3};
  fit.points = 4;
  return fit;
}

Analysis with(const ScalingFits& fits) {
  Analysis analysis;
  analysis.scaling = fits;
  return analysis;
}

Analysis with(const Transport& result) {
  Analysis analysis;
  analysis.results = {result};
  return analysis;
}

}  // namespace

TEST_CASE("exact power laws give back their exponents") {
  const ScalingFits fits = fit_scaling(family(1e-6), {0.1, 0.3});
  CHECK(fits.beta.exponent.value == Approx(2.5).epsilon(1e-9));
  CHECK(fits.gamma.exponent.value == Approx(1.7).epsilon(1e-9));
  CHECK(fits.alpha.exponent.value == Approx(1.7 / 2.5).epsilon(1e-9));  // eliminate mu
  CHECK(std::exp(fits.beta.intercept.value) == Approx(1.6).epsilon(1e-8));
  CHECK(fits.beta.points == 3);  // 0.1, 0.2, 0.3: both ends belong to the window
}

TEST_CASE("the error of an exponent is that of the line through points of one weight, whatever their errors") {
  // Two-valued replicates r = +-s: jackknife se^2 = (B-1)/B * B s^2 = 15 s^2 for B = 16. All points scatter in step, so
  // that the slope's replicates follow from the line fit of the shifted logarithms: algebra for equal signs.
  const double s = 1e-4;
  const ScalingFits fits = fit_scaling(family(s), {0.05, 0.6});
  CHECK(fits.beta.points == 5);
  // ln D shifts by +-s (1 + mu): the slope shifts by +-s times the regression of (1 + mu) on ln mu.
  double sw = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (double mu : {0.05, 0.1, 0.2, 0.3, 0.6}) {
    const double x = std::log(mu), y = 1 + mu;
    sw += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double slope = (sw * sxy - sx * sy) / (sw * sxx - sx * sx);
  CHECK(fits.beta.exponent.standard_error == Approx(std::sqrt(15.0) * s * slope).epsilon(1e-3));
}

TEST_CASE("chi squared of a power law counts the distance of its points in standard errors") {
  // Replicates +-s of B = 16 blocks, with signs orthogonal between the points: variance 15 s^2 each, no covariance.
  // Three points of one error at x = -1, 0, 1, of which the middle one lies d off: the line takes d/3 up, which leaves
  // -d/3, 2d/3, -d/3. What all points share moves the law and no point off it, however large.
  constexpr double s = 0.01, d = 0.2;
  const double shared = GENERATE(0.0, 0.5);
  std::vector<Replicated> x, y;
  for (const int at : {-1, 0, 1}) {
    Replicated abscissa, ordinate;
    abscissa.value = at;
    ordinate.value = 2.0 * at + (at == 0 ? d : 0);
    for (int block = 0; block < 16; ++block) {
      const auto sign = [&](int period) { return block / period % 2 == 0 ? 1 : -1; };
      abscissa.without_block.push_back(at);
      ordinate.without_block.push_back(ordinate.value + s * sign(1 << (at + 1)) + shared * sign(8));
    }
    x.push_back(abscissa);
    y.push_back(ordinate);
  }
  const ScalingFit fit = fit_power_law(x, y, {0.1, 0.3});
  CHECK(fit.exponent.value == Approx(2).epsilon(1e-12));
  const double bias_of_the_inverse = 15.0 / (16 - 3);
  CHECK(fit.scatter.chi2 == Approx(d * d * 6 / 9 / (15 * s * s) / bias_of_the_inverse));
  CHECK(fit.scatter.degrees_of_freedom == 1);
  x.pop_back();
  y.pop_back();
  const ScalingFit unknown = fit_power_law(x, y, {0.1, 0.3});
  CHECK(std::isnan(unknown.scatter.chi2));
  CHECK_FALSE(unknown.scatter.reason.empty());
}

TEST_CASE("points that follow no power law are told beside the exponent") {
  ScalingFits fits;
  fits.beta = exponent(2.07, 0.011);
  fits.beta.scatter = {32.1, 2, 4, {}};
  fits.gamma = exponent(1.0, 0.01);
  fits.gamma.scatter = {5.9, 2, 4, {}};  // 3 per degree of freedom is the limit
  const std::vector<Claim> claims = judge_claims(with(fits), {}, {});
  CHECK(claim(claims, "D-of-mu").remarks.find("power law is 32.1 on 2:") != std::string::npos);
  CHECK(claim(claims, "c-of-mu").remarks.find("single power") == std::string::npos);
}

TEST_CASE("exponents from ratios carry the bias of the offsets that slopes do not") {
  auto results = family(1e-6);
  constexpr double z = 95.763;  // layer 110
  for (MeasuredTransport& result : results) {
    // x_p = x_0 + c z with one x_0 for all mu, W^2 = D z: the ratio's c0 - c gains -x_0/z, its D nothing.
    const auto ratio = [](double c) { return c - 0.3 / z; };
    result.ratios = {{110, transform(ratio, result.c), result.D}};
  }
  const RatioScaling by_ratio = fit_ratio_scaling(results, 110, {0.1, 0.3});
  CHECK(by_ratio.z == Approx(z).margin(1e-3));
  CHECK(by_ratio.fits.beta.exponent.value == Approx(2.5).epsilon(1e-9));
  // Slope of ln(0.15 mu^1.7 + 0.3/z) on ln mu between neighbouring mu lies below 1.7: the mean over the window,
  // weighted by relative scatter, must too.
  const auto slowing = [&](double mu) { return std::log(0.15 * std::pow(mu, 1.7) + 0.3 / z); };
  const double steepest = (slowing(0.3) - slowing(0.2)) / std::log(0.3 / 0.2);
  const double flattest = (slowing(0.2) - slowing(0.1)) / std::log(0.2 / 0.1);
  CHECK(by_ratio.fits.gamma.exponent.value < steepest);
  CHECK(by_ratio.fits.gamma.exponent.value > flattest);
  CHECK(steepest < 1.7);
  CHECK(by_ratio.fits.alpha.exponent.value == Approx(by_ratio.fits.gamma.exponent.value / 2.5).epsilon(0.05));
  const RatioScaling nowhere = fit_ratio_scaling(results, 111, {0.1, 0.3});
  CHECK(nowhere.fits.beta.points == 0);
  CHECK_FALSE(nowhere.fits.beta.exponent.known());
}

TEST_CASE("results without scatter, unknown ones and impossible logarithms take no part") {
  auto results = family(1e-3);
  results[1].transport.exact = true;  // mu = 0.1
  results[2].c.value = tan30 + 0.01;  // mu = 0.2: c above c0
  for (double& c : results[2].c.without_block) c = tan30 + 0.01;
  const ScalingFits fits = fit_scaling(results, {0.05, 0.6});
  CHECK(fits.beta.points == 4);
  CHECK(fits.gamma.points == 3);
  const ScalingFits narrow = fit_scaling(results, {0.25, 0.35});
  CHECK(narrow.beta.points == 1);
  CHECK_FALSE(narrow.beta.exponent.known());
  CHECK_FALSE(narrow.beta.exponent.reason.empty());
}

TEST_CASE("claims follow the stated rule") {
  ScalingFits fits{exponent(2.45, 0.06), exponent(1.7, 0.05), exponent(0.68, 0.02)};
  auto claims = judge_claims(with(fits), {}, {});
  expect_verdicts(claims, {{"D-of-mu", "reproduced"}});
  CHECK(claim(claims, "D-of-mu").verdict == "reproduced");
  CHECK(claim(claims, "D-of-mu").expected == "reproduced");
  CHECK(claim(claims, "D-of-mu").z_score == Approx((2.45 - 2.5) / std::hypot(0.06, 0.05)));
  CHECK(claim(claims, "c-of-mu").verdict == "not reproduced");
  CHECK(claim(claims, "c-of-D").verdict == "not reproduced");
  CHECK(claim(claims, "frictionless").verdict == "not tested");
  CHECK(claim(claims, "differs-from-theory").verdict == "reproduced");
  CHECK(claim(claims, "c-of-D").remarks.find("γ/β is 0.694") != std::string::npos);
  // 20 % of 2.5 is 0.5: an error above 0.5/3 cannot exclude it, whatever the value.
  fits.beta = exponent(2.5, 0.17);
  CHECK(claim(judge_claims(with(fits), {}, {}), "D-of-mu").verdict == "not decided");
  fits.beta = exponent(3.2, 0.15);
  CHECK(claim(judge_claims(with(fits), {}, {}), "D-of-mu").verdict == "not reproduced");
  fits.beta.exponent = test::unknown("nothing was measured");
  CHECK(claim(judge_claims(with(fits), {}, {}), "D-of-mu").verdict == "not tested");
  CHECK(claim(judge_claims(with(fits), {}, {}), "D-of-mu").explanation.find("nothing was measured") !=
        std::string::npos);
}

TEST_CASE("the frictionless claim holds to rounding and no further") {
  Transport t;
  t.spec.sampler.mu = 0;
  t.exact = true;
  t.c.value = tan30 + 1e-15;
  t.c.standard_error = 0;
  t.D.value = 0;
  t.D.standard_error = 0;
  CHECK(claim(judge_claims(with(t), {}, {}), "frictionless").verdict == "reproduced");
  t.D.value = 1e-9;
  CHECK(claim(judge_claims(with(t), {}, {}), "frictionless").verdict == "not reproduced");
  t.D.value = 0;
  t.exact = false;
  CHECK(claim(judge_claims(with(t), {}, {}), "frictionless").verdict == "not reproduced");

  // An estimator that follows fluctuations finds none there: what is unknown contradicts nothing.
  t.c = test::unknown("piles without friction are all alike");
  CHECK(claim(judge_claims(with(t), {}, {}), "frictionless").verdict == "not tested");
  CHECK(claim(judge_claims(with(t), {}, {}), "frictionless").explanation == "Piles without friction are all alike.");
}
