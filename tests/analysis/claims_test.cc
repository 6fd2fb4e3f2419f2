#include "analysis/claims.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/synthetic_ensemble.h"
#include "kit/claim.h"
#include "kit/estimates.h"
#include "model/lattice.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using test::claim;
using test::known;

namespace {

constexpr int columns = 300;

FitSpec window() {
  return {.first_layer = 50, .last_layer = 130, .layer_step = 5, .shallow_layer = 50, .other_scaling_windows = {}};
}

/// x_p = c z and W^2 = D z.
KnownTransport straight_rays(double c, double D) {
  return {.c = c, .D = D, .position_offset = 0, .width_offset = 0, .alpha_thrust = 0.9};
}

/// One friction coefficient of a known response, analysed through the whole chain.
Analysis analysis_of(const KnownTransport& known, const SyntheticNoise& noise, double mu = 1.7) {
  MeasuredEnsemble ensemble = synthetic_ensemble(known, noise, columns, layers_to_record(window(), {}), 32, 100);
  ensemble.spec.sampler.mu = mu;
  return analyse({measure_transport(ensemble, window(), {}, 2)}, window(), {});
}

std::string verdict(const Analysis& analysis, const std::string& id) { return claim(analysis.claims, id).verdict; }

SyntheticNoise noise_of(double per_sample, std::uint64_t seed) { return {.per_sample = per_sample, .seed = seed}; }

}  // namespace

TEST_CASE("Every claim about the main line is decided, each once, and nothing measured leaves all open") {
  const std::vector<std::string> ids{"frictionless",
                                     "double-peak",
                                     "two-gaussians",
                                     "linear-position",
                                     "diffusive-width",
                                     "amplitude",
                                     "no-elastic-scaling",
                                     "closer-and-wider",
                                     "c-of-mu",
                                     "D-of-mu",
                                     "c-of-D",
                                     "differs-from-theory",
                                     "noise"};
  CHECK(claim_ids() == ids);
  for (const Claim& one : judge_claims({}, {}, {})) {
    INFO(one.id);
    CHECK(one.verdict == not_tested);
    CHECK_FALSE(one.explanation.empty());
    CHECK_FALSE(one.measured.known());
    CHECK_FALSE(one.measured.reason.empty());
  }
}

TEST_CASE("The rule for numbers") {
  constexpr PaperNumber beta{.value = 2.5, .error = 0.05}, exact{.value = 2.5};
  CHECK(judge_number(known(2.45, 0.06), beta).verdict == reproduced);
  CHECK(judge_number(known(2.45, 0.06), beta).z_score == Approx(-0.05 / std::hypot(0.06, 0.05)));
  CHECK(judge_number(known(3.2, 0.06), beta).verdict == not_reproduced);
  CHECK(judge_number(known(-0.8, 0.01), {.value = -0.5, .tolerance = 0.02}).verdict == not_reproduced);
  // What lies far off is not reproduced, however uncertain.
  CHECK(judge_number(known(9.0, 2.0), exact).verdict == not_reproduced);
  CHECK(judge_number(known(9.0, 2.2), exact).verdict == not_decided);
  // To be reproduced, the nearer of the values 20 % off must lie more than three errors away.
  CHECK(judge_number(known(2.6, 0.14), exact).verdict == not_decided);
  CHECK(judge_number(known(2.6, 0.13), exact).verdict == reproduced);
  CHECK(judge_number(known(2.6, 0.13), exact).rival.value == Approx(3));
  CHECK(judge_number(known(2.4, 0.13), exact).rival.value == Approx(2));
  CHECK(judge_number(Estimate{}, exact).verdict == not_tested);
  CHECK(judge_number(known(1, 0), {.value = 1}).verdict == reproduced);
  CHECK(judge_number(known(1.001, 0), {.value = 1}).verdict == not_reproduced);
}

TEST_CASE("A rival of a theory takes the place of 20 %") {
  constexpr PaperNumber linear{.value = 1, .tolerance = 0.02};
  const Rival elastic{2, "elastic scaling"};
  // 1.105(96): a deviation of 20 % would not stand out, the elastic rival does, by 9 errors.
  const NumberVerdict judged = judge_number(known(1.105, 0.096), linear, elastic);
  CHECK(judged.verdict == reproduced);
  CHECK(judged.rival_distance == Approx((1.105 - 2) / std::hypot(0.096, 0.02)));
  CHECK(judge_number(known(1.105, 0.096), linear).verdict == not_decided);
  CHECK(judge_number(known(1.4, 0.21), linear, elastic).verdict == not_decided);
  // The paper's own error does not bring the rival nearer.
  CHECK(judge_number(known(1, 0.1), {.value = 1, .error = 0.5}, elastic).verdict == reproduced);
}

TEST_CASE("The systematic error counts in quadrature") {
  Estimate measured = known(0.661, 0.026);
  constexpr PaperNumber alpha{.value = 0.4, .error = 0.01};
  CHECK(judge_number(measured, alpha).z_score == Approx(0.261 / std::hypot(0.026, 0.01)));
  measured.systematic = 0.08;
  CHECK(total_error(measured) == Approx(std::hypot(0.026, 0.08)));
  CHECK(judge_number(measured, alpha).verdict == not_reproduced);
  CHECK(judge_number(measured, alpha).z_score == Approx(0.261 / std::hypot(0.026, 0.08, 0.01)));
  measured.systematic = 0.1;
  CHECK(judge_number(measured, alpha).verdict == not_decided);
  CHECK(judge_number(measured, alpha, Rival{1, "stochastic theory"}).verdict == reproduced);
}

TEST_CASE("A claim that a number is not another theory's is decided by that number's distance") {
  constexpr PaperNumber paper{.value = 0.4, .error = 0.01};
  const Rival theory{1, "stochastic theory"};
  const auto verdict_at = [&](double value, double error) {
    Claim claim = open_claim("", "", "");
    judge_by_exclusion(claim, known(value, error), paper, theory, "The exponent");
    CHECK(claim.rival_distance == Approx((value - 1) / error));
    CHECK_FALSE(std::isfinite(claim.z_score));
    return claim.verdict;
  };
  CHECK(verdict_at(0.66, 0.03) == reproduced);
  CHECK(verdict_at(0.96, 0.03) == not_reproduced);
  CHECK(verdict_at(0.7, 0.11) == not_decided);
}

TEST_CASE("What more piles would decide is said, and how many") {
  // (0.2/3)^2 = 0.0044 is the variance allowed; 0.2^2 = 0.04 is 9 times that.
  CHECK_THAT(cost_of_deciding(known(1, 0.2), {.value = 1}, 1.2), Contains("about 9.0 times as many piles"));
  // Not "1.0 times as many".
  CHECK_THAT(more_piles(1.04), Contains("somewhat more piles"));
  CHECK_THAT(cost_of_deciding(known(1, 0.2), {.value = 1, .tolerance = 0.1}, 1.2),
             Contains("more piles do not decide"));
  Estimate systematic = known(1, 0.2);
  systematic.systematic = 0.07;
  CHECK_THAT(cost_of_deciding(systematic, {.value = 1}, 1.2), Contains("more piles do not decide"));
}

TEST_CASE("A verdict names both distances, and what it would cost if there is none") {
  Claim far, near;
  judge_by_number(far, known(0.68, 0.03), {.value = 0.4, .error = 0.01}, Rival{1, "stochastic theory"}, "The exponent");
  CHECK(far.verdict == not_reproduced);
  CHECK(far.rival == 1);
  CHECK_THAT(far.explanation, Contains("is 0.680(30), 8.9 combined errors above the paper’s value and 11 from 1.0 "
                                       "(stochastic theory)."));
  judge_by_number(near, known(0.41, 0.03), {.value = 0.4, .error = 0.01}, {}, "The exponent");
  CHECK(near.verdict == not_decided);
  CHECK_THAT(near.explanation,
             Contains("0.32 combined errors above the paper’s value and 2.3 from 0.48 (20 % off); about"));
  Claim own;
  own.beyond_paper = true;
  judge_by_number(own, known(1.18, 0.02), {.value = 1}, {}, "The power");
  CHECK_THAT(own.explanation, Contains("9.0 combined errors above the 1.0 of this test"));
}

namespace {

Transport at_friction(double mu, double c, double D, double background) {
  Transport made;
  made.spec.sampler.mu = mu;
  made.c = known(c, 0.0005);
  made.D = known(D, 0.002);
  made.centre_background = known(background, 0.005);
  made.fitted_area = known(0.998, 0.005);
  return made;
}

Claim judged(const std::vector<Transport>& results, const std::string& id) {
  Analysis analysis;
  analysis.results = results;
  return claim(judge_claims(analysis, window(), {}), id);
}

}  // namespace

TEST_CASE("Peaks are closer and wider where c falls and D grows over the small frictions") {
  const auto a = at_friction(0.1, 0.575, 0.005, 0), b = at_friction(0.2, 0.568, 0.026, 0),
             c = at_friction(0.3, 0.56, 0.07, 0), farther = at_friction(1, 0.58, 0.06, 0);
  CHECK(judged({a, b, c}, "closer-and-wider").verdict == reproduced);
  CHECK(judged({a, b, c, farther}, "closer-and-wider").verdict == reproduced);  // the paper speaks of small friction
  CHECK(judged({a, at_friction(0.2, 0.555, 0.026, 0), c}, "closer-and-wider").verdict == not_reproduced);
  CHECK(judged({a, at_friction(0.2, 0.568, 0.09, 0), c}, "closer-and-wider").verdict == not_reproduced);
  CHECK(judged({a, at_friction(0.3, 0.574, 0.07, 0)}, "closer-and-wider").verdict == not_decided);
  CHECK(judged({a}, "closer-and-wider").verdict == not_tested);
}

TEST_CASE("Two Gaussians describe a profile that leaves little between the peaks") {
  CHECK(judged({at_friction(0.3, 0.56, 0.07, 0.01)}, "two-gaussians").verdict == reproduced);
  CHECK(judged({at_friction(0.3, 0.56, 0.07, 0.04)}, "two-gaussians").verdict == not_decided);
  CHECK(judged({at_friction(0.3, 0.56, 0.07, 0.08)}, "two-gaussians").verdict == not_reproduced);
  Transport area = at_friction(0.3, 0.56, 0.07, 0.01);
  area.fitted_area = known(0.9, 0.01);
  CHECK(judged({area}, "two-gaussians").verdict == not_reproduced);
  const Claim wide = judged({at_friction(0.3, 0.56, 0.07, 0.01), at_friction(0.8, 0.55, 0.9, 0.1)}, "two-gaussians");
  CHECK(wide.verdict == reproduced);
  CHECK_THAT(wide.remarks, Contains("0.1000(50) at μ = 0.8"));
  CHECK_THAT(wide.quantity, EndsWith("up to μ = 0.3"));
  CHECK_THAT(judged({at_friction(0.25, 0.56, 0.07, 0.01)}, "two-gaussians").quantity, EndsWith("up to μ = 0.25"));

  // What decides is what the sentence tells: here the area, at another friction than the largest share.
  const Claim by_area = judged({area, at_friction(0.2, 0.56, 0.07, 0.03)}, "two-gaussians");
  CHECK_THAT(by_area.explanation, Contains("missing from the area") && Contains("0.100(10) at worst, at μ = 0.3") &&
                                      Contains("exceeds it by more than three standard errors"));
  // A friction whose peaks are too narrow is named; one whose response has another shape refutes the claim.
  Transport skipped = at_friction(0.1, 0.575, 0.005, 0);
  skipped.centre_background = skipped.fitted_area = test::unknown("the width of a bead hides it");
  DepthFit depth;
  depth.layer = window().first_layer;
  depth.width = known(0.4, 0.01);
  depth.chi2_per_dof = 1;
  depth.degrees_of_freedom = 200;
  skipped.depths = {depth};
  const Claim narrow = judged({skipped, at_friction(0.3, 0.56, 0.07, 0.01)}, "two-gaussians");
  CHECK(narrow.verdict == reproduced);
  CHECK_THAT(narrow.remarks, Contains("Not known at μ = 0.1"));
  skipped.depths[0].chi2_per_dof = 3;
  skipped.depths[0].misfit_at_least = 0.4;
  CHECK(judged({skipped, at_friction(0.3, 0.56, 0.07, 0.01)}, "two-gaussians").verdict == not_reproduced);
  CHECK(judged({skipped}, "two-gaussians").verdict == not_reproduced);
}

TEST_CASE("Two separate peaks are found, and their laws") {
  const KnownTransport known = straight_rays(0.5, 0.15);
  const Analysis analysis = analysis_of(known, noise_of(0.1, 3));
  for (const char* id :
       {"double-peak", "linear-position", "diffusive-width", "amplitude", "no-elastic-scaling", "noise"}) {
    INFO(id << ": " << claim(analysis.claims, id).explanation);
    CHECK(verdict(analysis, id) == reproduced);
  }
  const Exponents& exponents = analysis.results[0].exponents;
  CHECK(std::abs(exponents.position.value - 1) < 5 * exponents.position.standard_error);
  CHECK(std::abs(exponents.width.value - 1) < 5 * exponents.width.standard_error);
  CHECK(std::abs(exponents.amplitude.value + 0.5) < 5 * exponents.amplitude.standard_error);
  CHECK(std::abs(exponents.noise.value + 0.5) < 5 * exponents.noise.standard_error);
  CHECK(exponents.width.standard_error < 0.05);
  CHECK(exponents.amplitude.standard_error < 0.03);
  // The experiment must reach the friction that the claim names.
  CHECK(verdict(analysis_of(known, noise_of(0.1, 3), 0.6), "double-peak") == not_tested);
}

TEST_CASE("One peak is told from two, and noise from both") {
  // c = 0: a single Gaussian of W = 6 to 10.
  const KnownTransport single = straight_rays(0, 0.7);
  const Analysis clear = analysis_of(single, noise_of(0.05, 4));
  CHECK(verdict(clear, "double-peak") == not_reproduced);
  CHECK_THAT(claim(clear.claims, "double-peak").explanation, Contains("have merged at μ = 1.7"));
  // The same under noise as high as the response says nothing.
  const Analysis blurred = analysis_of(single, noise_of(5, 5));
  CHECK(verdict(blurred, "double-peak") == not_decided);
  // Two Gaussians with x_p < W are told from one Gaussian but have a single maximum: x_p = 0.8 W at z = 66.
  const KnownTransport merged = straight_rays(0.08, 0.7);
  const Analysis together = analysis_of(merged, noise_of(0.02, 6));
  const auto& depths = together.results[0].depths;
  CHECK(depths.front().evidence.for_two_peaks < -25);
  CHECK(depths.back().evidence.against_one_gaussian > 25);
  CHECK(verdict(together, "double-peak") == not_reproduced);
}

TEST_CASE("Noise about one Gaussian makes two peaks no more often than it may", "[unsanitized]") {
  // 40 ensembles x 17 depths. The likelihood ratio against one Gaussian exceeds 9 with probability 0.00135 per depth if
  // its distribution is half chi^2 with one degree of freedom: 0.9 in 680. Smoothed noise spectra widen it a little.
  int exceeding = 0, two_peaks = 0, depths = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Analysis analysis = analysis_of(straight_rays(0, 0.7), noise_of(0.3, 100 + seed));
    for (const DepthFit& depth : analysis.results[0].depths) {
      if (!std::isfinite(depth.evidence.for_two_peaks)) continue;
      ++depths;
      exceeding += depth.evidence.against_one_gaussian > 9;
      two_peaks += depth.evidence.for_two_peaks > 9;
    }
  }
  INFO(depths << " depths, " << exceeding << " above 9, " << two_peaks << " with two peaks");
  CHECK(depths >= 600);
  CHECK(exceeding <= 8);
  CHECK(two_peaks <= 4);
}

TEST_CASE("Growth that is not linear is not reproduced, and noise leaves it open") {
  KnownTransport bent = straight_rays(0.5, 0.15);
  bent.position_power = 0.85;
  bent.width_power = 1.5;
  const Analysis analysis = analysis_of(bent, noise_of(0.05, 7));
  CHECK(verdict(analysis, "linear-position") == not_reproduced);
  CHECK(verdict(analysis, "diffusive-width") == not_reproduced);
  CHECK(verdict(analysis, "amplitude") == not_reproduced);
  CHECK(analysis.results[0].exponents.position.value == Approx(0.85).margin(0.01));
  CHECK(analysis.results[0].exponents.width.value == Approx(1.5).margin(0.1));
  CHECK(analysis.results[0].exponents.amplitude.value == Approx(-0.75).margin(0.03));
  const LineTest& line = analysis.results[0].position_line;
  CHECK(line.chi2 > 100 * line.degrees_of_freedom);
  const Analysis blurred = analysis_of(bent, noise_of(1.5, 8));
  CHECK(verdict(blurred, "diffusive-width") == not_decided);
  CHECK_THAT(claim(blurred.claims, "diffusive-width").explanation, Contains("times as many piles"));
}

TEST_CASE("Straight lines are called bent no more often than they may be", "[unsanitized]") {
  // z-scores of the powers over 60 ensembles: |z| > 3 with probability 0.0027, by Student's t with 31 degrees of
  // freedom 0.0053 each. 180 powers: one expected, more than six has probability below 1e-4.
  int beyond = 0;
  double chi2 = 0;
  int degrees_of_freedom = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Analysis analysis = analysis_of(straight_rays(0.5, 0.15), noise_of(0.2, 500 + seed));
    const Transport& result = analysis.results[0];
    beyond += std::abs(result.exponents.position.value - 1) > 3 * result.exponents.position.standard_error;
    beyond += std::abs(result.exponents.width.value - 1) > 3 * result.exponents.width.standard_error;
    beyond += std::abs(result.exponents.noise.value + 0.5) > 3 * result.exponents.noise.standard_error;
    chi2 += result.position_line.chi2 + result.width_line.chi2;
    degrees_of_freedom += result.position_line.degrees_of_freedom + result.width_line.degrees_of_freedom;
  }
  CHECK(beyond <= 6);
  // 720 degrees of freedom: standard deviation 38, wider by the uncertain covariance (B/(B - m) = 4/3).
  INFO(chi2 << " on " << degrees_of_freedom);
  CHECK(degrees_of_freedom == 720);
  CHECK(std::abs(chi2 - degrees_of_freedom) < 5 * 38 * 4 / 3.0);
}

TEST_CASE("Noise that does not fall is seen: a response of another shape") {
  KnownTransport skirt = straight_rays(0.5, 0.15);
  skirt.in_the_middle = 0.03;  // less than what makes a depth count as another shape
  const Analysis analysis = analysis_of(skirt, noise_of(0.02, 9));
  CHECK(analysis.results[0].exponents.noise.value > -0.3);
  CHECK(verdict(analysis, "noise") == not_decided);
  CHECK_THAT(claim(analysis.claims, "noise").remarks, Contains("the response has not exactly the shape"));
}

TEST_CASE("A rough power refutes no straight line that the depths meet") {
  struct Case {
    double error, chi2;
    const char* verdict;
  };
  // 160 piles, whose power lies 4.7 of its errors off; then lines that are refused, and a power known well.
  for (const Case& one : {Case{0.26, 15.7, not_decided}, {0.26, 40, not_reproduced}, {0.09, 6, not_reproduced}}) {
    Analysis analysis;
    analysis.results = {at_friction(0.3, 0.56, 0.07, 0)};
    Transport& result = analysis.results.front();
    result.exponents.width = analysis.mean_exponents.width = known(2.23, one.error);
    result.exponents.amplitude = analysis.mean_exponents.amplitude = known(-1.13, one.error);
    result.width_line.chi2 = result.height_line.chi2 = one.chi2;
    result.width_line.degrees_of_freedom = result.height_line.degrees_of_freedom = 6;
    const std::vector<Claim> claims = judge_claims(analysis, window(), {});
    CAPTURE(one.error, one.chi2);
    CHECK(claim(claims, "diffusive-width").verdict == one.verdict);
    CHECK(claim(claims, "amplitude").verdict ==
          (one.error > 0.2 && one.chi2 > 20 ? not_decided : std::string(one.verdict)));
    CHECK(claim(claims, "no-elastic-scaling").verdict == one.verdict);
    const bool open = one.verdict == std::string(not_decided);
    CHECK((claim(claims, "diffusive-width").remarks.find("no sure error") != std::string::npos) == open);
  }
}

TEST_CASE("Nothing is said of the paper's load by a larger one") {
  Transport heavy = at_friction(0.3, 0.56, 0.07, 0.08);
  CHECK(judged({heavy}, "two-gaussians").verdict == not_reproduced);
  heavy.spec.response.overload = 5;
  CHECK(judged({heavy}, "two-gaussians").verdict == not_tested);
  CHECK_THAT(judged({heavy}, "two-gaussians").explanation, Contains("an overload of one load") && Contains("not of 5"));
  heavy.spec.response.estimator = EstimatorName::multiplexed;  // which has none
  CHECK(judged({heavy}, "two-gaussians").verdict == not_reproduced);
}

TEST_CASE("Peaks that the width of a bead hides are no single peak") {
  for (const double width : {0.2, 2.0}) {
    Transport result = at_friction(0.05, 0.577, 0.001, 0);
    result.peak_separation = known(7.8, 0.001);
    DepthFit depth;
    depth.layer = window().first_layer;
    depth.width = known(width, 0.001);
    depth.evidence.for_two_peaks = -1000;
    result.depths = {depth};
    CHECK(judged({result}, "double-peak").verdict == (width < 0.5 ? not_tested : not_reproduced));
  }
}

TEST_CASE("One friction coefficient is no range of them") {
  CHECK(over_all_values({0.3}) == "at μ = 0.3");
  CHECK(over_all_values({0.1, 0.3}) == "over μ = 0.1 and 0.3");
  CHECK(over_all_values({0.1, 0.2, 0.3}) == "over μ = 0.1, 0.2 and 0.3");
  CHECK(over_all_values({0.1, 0.2, 0.3, 0.4, 0.6}) == "over 5 values of μ from 0.1 to 0.6");
}

TEST_CASE("Whether peaks have merged is told by all depths of the window together") {
  Transport result;
  result.spec.sampler.mu = 1.7;
  Analysis analysis;
  const auto verdict_at = [&](double separation, double error) {
    result.peak_separation = known(separation, error);
    analysis.results = {result};
    return claim(judge_claims(analysis, {}, {}), "double-peak");
  };
  CHECK(verdict_at(1.6, 0.1).verdict == reproduced);
  CHECK(verdict_at(0.4, 0.1).verdict == not_reproduced);
  const Claim open = verdict_at(1.25, 0.1);  // 2.5 of 5 errors
  CHECK(open.verdict == not_decided);
  CHECK(open.measured.value == 1.25);
  CHECK_THAT(open.explanation, Contains("about 4.0 times as many piles"));
  CHECK_THAT(verdict_at(1, 0.1).explanation, Contains("exactly where peaks merge"));
  result.peak_separation = test::unknown("no depth could be fitted");
  analysis.results = {result};
  CHECK(claim(judge_claims(analysis, {}, {}), "double-peak").verdict == not_decided);
}

TEST_CASE("An offset of W² does not bend the height of the peaks") {
  // W^2 = 3 + 0.15 z: the height itself falls as z^-0.39 over the window.
  KnownTransport wide = straight_rays(0.5, 0.15);
  wide.width_offset = 3;
  const Analysis analysis = analysis_of(wide, noise_of(0.05, 11));
  const Estimate& power = analysis.results[0].exponents.amplitude;
  CHECK(std::abs(power.value + 0.5) < 5 * power.standard_error);
  CHECK(power.standard_error < 0.03);
}
