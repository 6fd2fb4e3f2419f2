#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/shape_fit.h"
#include "ensemble/ensemble_spec.h"
#include "model/lattice.h"
#include "sampling/sampler_spec.h"
#include "storage/ensemble_file.h"

namespace granuscope {
/// An exponent that changes steadily: ln y is a parabola in ln x. Its slope at both ends of the points.
struct RunningExponent {
  double low = 0, high = 0;  ///< the ends, x itself
  Estimate at_low, at_high;
  LineTest scatter;  ///< of the points about the parabola; unknown where the exponents are

  /// Whether the points scatter about the parabola by no more than their errors allow.
  bool meets_the_points() const {
    return at_low.known() && scatter.degrees_of_freedom > 0 &&
           scatter.chi2 <= largest_chi2_per_dof * scatter.degrees_of_freedom;
  }
  static constexpr double largest_chi2_per_dof = 3;
};

/// A power law y = exp(intercept) x^exponent fitted on log-log axes.
struct ScalingFit {
  Estimate exponent;
  Estimate intercept;              ///< ln of the prefactor
  std::array<double, 2> window{};  ///< of mu, inclusive
  int points = 0;
  LineTest scatter;         ///< of the points about the law; unknown where the exponent is
  RunningExponent running;  ///< what they follow instead; unknown below four points

  /// Whether the points scatter about every power law by more than their errors: the exponent is then one between those
  /// of parts of the window, and its statistical error says nothing.
  bool misses_the_points() const {
    return scatter.degrees_of_freedom > 0 &&
           scatter.chi2 > RunningExponent::largest_chi2_per_dof * scatter.degrees_of_freedom;
  }
};

/// The double-Gaussian fit of the response at one layer (the paper's G(x), integrated over the bead width).
struct DepthFit {
  int layer = 0;
  double z = 0;                ///< bead diameters
  Estimate peak_position;      ///< x_p, bead diameters
  Estimate width;              ///< W, bead diameters
  Estimate width_squared;      ///< W^2
  Estimate thrust_ratio;       ///< alpha_n of the contacts leaving this layer
  Estimate peak_height;        ///< per bead diameter and unit overload, see shape_fit.h
  Estimate fitted_area;        ///< with the area left free, see shape_fit.h
  Estimate centre_background;  ///< share spread evenly between the peaks, see shape_fit.h
  PeakEvidence evidence;       ///< for two peaks against one; NaN where nothing was fitted
  double chi2_per_dof = 0;     ///< with the noise spectrum estimated from the ensemble
  int degrees_of_freedom = 0;
  double misfit = 0;           ///< share of the response that the shape misses, see shape_fit.h
  double misfit_at_least = 0;  ///< the same, two of its standard errors lower
  bool identifiable = false;
  std::string reason;  ///< why not identifiable
};

/// A measured mean response at one layer with its fit, for a figure. Vectors have one entry per bead, x ascending.
struct ResponseProfile {
  int layer = 0;
  double z = 0;
  std::vector<double> x;         ///< bead diameters from the overload
  std::vector<double> pressure;  ///< P(x, z), mirror symmetrised, unit overload
  std::vector<double> standard_error;
  std::vector<double> fit;  ///< the fitted G, integrated over the bead width
  double c0 = tan30;        ///< of its lattice
};

/// The exponents of depth, and of the number of piles, for which the paper has values, from the depths of the fit
/// window.
struct Exponents {
  Estimate position;   ///< p of x_p = x_0 + A z^p (growth_exponent); the paper: 1
  Estimate width;      ///< p of W^2 = w_0 + A z^p; the paper: 1
  Estimate amplitude;  ///< p of the peak height h, 1/h^2 = a + A z^(-2p); the paper: -1/2
  Estimate noise;      ///< p of the rms residual A N^p (noise_exponent); the paper: -1/2
};

/// Whether an ensemble became as precise as the experiment asks.
struct PrecisionOutcome {
  bool asked = false;
  double c = 0, D = 0;  ///< standard errors asked for; 0: not asked for
  bool reached = false;
  std::string reason;  ///< why not; not empty if and only if it was asked for and not reached
};

/// What c and D become in a window beside that of the fit, or under other weights.
struct FitVariation {
  std::string change;  ///< "without_shallowest_quarter", "without_deepest_quarter", "longer_above" or "equal_weights"
  std::array<int, 2> layers{};  ///< first and last layer; 0 if unknown
  int depths = 0;
  Estimate c, D;
  Estimate c_shift, D_shift;  ///< minus those of the fit, with their own errors
};

/// Everything measured on one ensemble.
struct Transport {
  EnsembleSpec spec;          ///< of the ensemble it was measured on
  std::uint64_t samples = 0;  ///< piles that entered the averages
  std::vector<FailedSample> failed;
  PrecisionOutcome precision;
  bool exact = false;  ///< zero variance: exact moments, standard errors 0, no part in log-log fits

  Estimate c;                          ///< slope of x_p over the window
  Estimate D;                          ///< slope of W^2 over the window
  Estimate position_offset;            ///< x_0 of x_p = x_0 + c z
  Estimate width_offset;               ///< w_0 of W^2 = w_0 + D z
  Estimate alpha_thrust;               ///< mean thrust ratio over the window
  Estimate c_thrust;                   ///< c0 * sqrt(alpha_thrust)
  Estimate c_minus_c_thrust;           ///< their difference, with its own (correlated) error
  std::array<int, 2> window_layers{};  ///< first and last layer of the fit window
  int depths_in_window = 0;

  std::vector<FitVariation> variations;  ///< their spread is the systematic error of c and D
  Estimate fitted_area;                  ///< mean over the window, see shape_fit.h
  Estimate centre_background;            ///< likewise
  Estimate c_beside, D_beside;           ///< slopes of x_p and W^2 beside such a background, see there
  /// chi^2 per degree of freedom of two Gaussians and with such a background, means over the window; NaN where nothing
  /// was fitted.
  double chi2_per_dof = std::numeric_limits<double>::quiet_NaN();
  double chi2_beside_per_dof = std::numeric_limits<double>::quiet_NaN();
  double largest_misfit = 0;  ///< largest misfit_at_least over the window

  /// Sum of x_p over that of W, over the depths of the window where a shape was fitted. Two Gaussians make two peaks
  /// where x_p > W.
  Estimate peak_separation;
  Exponents exponents;
  LineTest position_line;  ///< of x_p = x_0 + c z
  LineTest width_line;     ///< of W^2 = w_0 + D z
  LineTest height_line;    ///< of 1/h^2, likewise

  double draws_per_bead = 0;
  double repaired_per_bead = 0;
  double backtracked_per_bead = 0;
  double rounded_per_bead = 0;       ///< share put onto the end of a band that only rounding missed
  bool chained = false;              ///< the piles come from chains (law polytope) and depend on each other
  double burn_in = 0, thinning = 0;  ///< of the chains, sweeps
  Estimate effective_samples;        ///< of the chains, see jackknife.h
  FlatTest flat;                     ///< likewise

  std::vector<DepthFit> depths;           ///< ascending, also shallower than the window
  std::vector<ResponseProfile> profiles;  ///< of the layers asked for

  const ScanParameter* scan = &friction_parameter();  ///< what differs from result to result

  RowGeometry rows() const { return rows_of(spec.sampler.model, spec.lattice.angle); }
  double c0() const { return rows().ray(); }
  double scanned() const { return scan->value(spec.sampler); }
  std::string at() const { return scan->at(spec.sampler); }  ///< "μ = 0.3"
  bool is_frictionless() const { return spec.sampler.model.has_contacts() && spec.sampler.mu == 0; }
};

struct ScalingFits {
  ScalingFit beta;   ///< D against mu
  ScalingFit gamma;  ///< c0 - c against mu
  ScalingFit alpha;  ///< c0 - c against D
};

/// c and D read in another way than as slopes of the main line, or at another friction, with their exponents.
struct OtherReading {
  struct Point {
    double mu = 0;
    Estimate c, D;
  };
  std::string id;     ///< "at_one_depth", "slopes", or of a study: its name in summary.json and in files of figures
  std::string label;  ///< "z = 75.0": its name in figures
  std::vector<Point> points;  ///< ascending in mu
  ScalingFits fits;
  double c0 = tan30;
};

/// The exponents from a choice beside that of the fit.
struct ScalingVariation {
  std::string change;  ///< as in FitVariation, or "without_lowest_mu", "without_highest_mu"
  ScalingFits fits;
  Estimate beta_shift, gamma_shift, alpha_shift;  ///< minus the exponents of the fit itself
};

/// One claim of the paper held against the measurement.
struct Claim {
  std::string id;         ///< "D-of-mu", ...
  std::string statement;  ///< the claim in one sentence
  std::string verdict;    ///< one of the four of claims.h
  std::string expected;   ///< the verdict the experiment file expects, empty if none
  std::string quantity;   ///< what `measured` is, in a few words
  Estimate measured;
  double paper = 0;  ///< NaN where the paper gives no number
  double paper_error = 0;
  double tolerance = 0;       ///< granted to it on top, in quadrature
  double z_score = 0;         ///< the pull; NaN where the claim is not decided by a number
  double rival = 0;           ///< the value that must be excluded before the paper's counts as reproduced; NaN: none
  std::string rival_name;     ///< what predicts it, empty if there is none
  double rival_distance = 0;  ///< of `measured` from it in standard errors; NaN: none
  std::string explanation;    ///< why, in one sentence
  std::string remarks;        ///< further sentences, may be empty
  bool beyond_paper = false;  ///< the paper prints no such number: the program's own test
  bool power_law = true;      ///< false: `measured` averages over powers that differ, and its error says nothing
};

/// What the analysis stage hands on.
struct Analysis {
  const ScanParameter* scan = &friction_parameter();  ///< that of all results
  std::vector<Transport> results;                     ///< ascending in it
  ScalingFits scaling;                                ///< over the primary window
  std::vector<ScalingVariation> variations;           ///< of the windows of depth and of mu
  std::vector<ScalingFits> other_windows;
  std::vector<OtherReading> readings;  ///< of studies, which the main line does not know
  Exponents mean_exponents;            ///< over all mu with scatter, see scaling.h
  Estimate mean_position_offset;       ///< x_0, likewise
  std::vector<Claim> claims;

  double c0() const { return results.empty() ? tan30 : results.front().c0(); }
  double angle() const { return results.empty() ? usual_angle : results.front().spec.lattice.angle; }
};

/// The propagation coefficient that follows from the thrust ratio alone: c = c0 sqrt(kappa), at 30 degrees by default.
inline double speed_from_thrust(double kappa, double c0 = tan30) { return c0 * std::sqrt(kappa); }

/// The thrust ratio of uniformly loaded piles at one recorded layer.
struct ThrustAtDepth {
  int layer = 0;
  double z = 0;  ///< bead diameters
  Estimate thrust_ratio;
  Estimate weight_variance;  ///< <(w - 1)^2>
};

/// Thresholds of the claims' tests beside the rule for numbers (claims.h). They stand in the experiment file,
/// chosen before the numbers.
struct ClaimSpec {
  /// Difference in chi^2 from which one shape counts as preferred over another: five standard deviations, so that some
  /// hundred depths together meet it by chance once in 10^4 experiments.
  double decisive_chi2 = 25;
  /// The friction coefficient that an experiment must reach for what the paper claims "up to mu about 1.7".
  double highest_mu = 1.7;
  /// Share of the response that two Gaussians which describe a profile well may leave out.
  double largest_remainder = 0.05;
  /// Standard error granted to the exponent of a law that holds asymptotically, where the window ends at a finite
  /// depth.
  double exponent_tolerance = 0.02;
};

}  // namespace granuscope
