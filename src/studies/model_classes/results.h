#pragma once

#include <filesystem>
#include <optional>

#include "analysis/double_gaussian.h"
#include "analysis/mean_response.h"
#include "sampling/model_spec.h"
#include "studies/sound_form.h"
#include "studies/study.h"

namespace granuscope {
/// What noise that is correlated in depth makes of the mean response, to second order in it: with Delta the standard
/// deviation of v relative to what it changes (1 + v),
///   c^2 = c0^2 (1 - kappa Delta^2),   D = D0 + spreading Delta^2.
struct NoiseShift {
  double kappa = 0, spreading = 0;  ///< dimensionless, bead diameters
};

/// The theory of a model's noise. Of noise that is independent from row to row nothing is left of it.
struct NoiseTheory {
  double c0 = 0, D0 = 0;  ///< of the medium without noise that has the same means
  double disorder = 0;    ///< Delta
  double cell = 0;        ///< width within which noise is alike, bead diameters
  NoiseShift wide;        ///< of peaks wider than cells, and of c_thrust: the limit k -> 0 of the paper's theory
  /// Of peaks that are narrower, stochastic OSL only: they are handed on without being thrown back, and only run faster
  /// or slower by the noise that they meet.
  std::optional<NoiseShift> narrow;

  /// Of peaks of that width.
  const NoiseShift& shift(double width) const { return narrow && width < cell ? *narrow : wide; }
  double c(double width) const;
  double D(double width) const { return D0 + shift(width).spreading * disorder * disorder; }
};

/// Of stochastic OSL in the continuum, g_x and g_z being the triangles that cells at random places give. To second
/// order a wave e^(ikx) meets c(k)^2 = c0^2 (1 + Delta^2 Q), 2 Q = int du g_z(u/c0) {[g_x' + ik g_x] e^(2iku) + g_x' -
/// ik g_x}, the first part thrown back twice, and D = -2 Im c(k)/k. So kappa = int du g_z (-g_x') and spreading = c0
/// int du u g_z
/// (-g_x') as k -> 0; kappa/2 + 1/4 and c0/2 int du g_z g_x for k far above 1/cell. And of the three-leg model whose
/// noise is free, on its lattice, from the force that comes back to where it was handed down otherwise, by the same
/// steps for k -> 0. Throws std::logic_error for another model.
NoiseTheory noise_theory(const ModelSpec& model);

/// How stresses grow with depth: sigma_zz is exact, 1 + (n + 1) g below layer n, sigma_xx = kappa sigma_zz / 3.
struct StressAtDepth {
  double z = 0, weight = 0;  ///< mean weight that leaves a bead there
  Estimate thrust_ratio;     ///< kappa
  Estimate weight_variance;  ///< over the square of the mean
};

/// The response of one model with one value of its parameter.
struct ModelResponse {
  std::string series;     ///< "three-leg, free": what is scanned together
  std::string parameter;  ///< "p̄ = 0.1"; empty: there is none
  SamplerSpec sampler;    ///< its piles
  std::string model;      ///< "three-leg"
  double bead_weight = 0;
  std::uint64_t samples = 0;
  std::array<int, 2> layers{};        ///< of the window
  std::array<double, 2> z{};          ///< their depths
  double speed_without_disorder = 0;  ///< c0 of the series

  int peaks = 1;  ///< of the best shape at the deepest layer
  Estimate c, D;  ///< slopes of x_p and W^2 of two Gaussians; D of one Gaussian where there is one peak
  Estimate c_thrust;
  Estimate slowing;                        ///< c0 - c
  Estimate width_exponent;                 ///< power of z in W^2
  double c_expected = 0, D_expected = 0;   ///< of theory, of noise to second order; NaN where none is known
  std::optional<NoiseTheory> theory;       ///< of noise that is correlated
  Estimate speed_loss, spreading_gain;     ///< then 1 - c^2/c0^2 and D - D0, with its c0 and D0
  Estimate thrust_loss;                    ///< and 1 - c_thrust^2/c0^2
  double width = 0;                        ///< W of two Gaussians in the deepest layer
  std::vector<StressAtDepth> stress;       ///< of all recorded layers of beads
  Estimate middle, c_of_middle, traction;  ///< three-leg: <p>, c0 sqrt(1 - <p>), share of beads on a pulling leg
  Estimate share_of_mean;                  ///< of c0 - c that <p> alone gives

  ResponseShape shape = ResponseShape::two_gaussians;  ///< best at most depths of the window
  FittedResponseShapes fits;                           ///< at the deepest one
  std::string verdict;                                 ///< class of models
  std::optional<ResponseProfile> profile;              ///< at the deepest layer
};

/// With the replicates that a power law over a series needs; empty where unknown.
struct MeasuredModel {
  ModelResponse response;
  Replicated slowing, D;
};

/// `series` and `parameter` name it.
MeasuredModel measure_model(const MeasuredEnsemble& ensemble, const FitSpec& fit, std::string series,
                            std::string parameter, int threads);

/// Classes: a best shape together with how fast its width grows.
std::string class_of_model(ResponseShape shape, const Estimate& width_exponent);

/// Where a pulling leg appears in the free three-leg model under a uniform load: a layer-by-layer calculation that
/// takes pushing legs for granted has to stop there.
struct TractionDepth {
  double middle = 0, noise = 0;  ///< p = middle +- noise
  std::uint64_t samples = 0;
  int columns = 0;
  Estimate z;  ///< down to which one bead of a pile of these columns stands on a pulling leg, in the mean
};

TractionDepth measure_traction(const MeasuredEnsemble& ensemble);

/// c0 - c as a power of D over those of one series whose c and D are known.
ScalingFit slowing_against_spreading(const std::vector<const MeasuredModel*>& series);

/// Those that are scanned together, with the power law of c0 - c against D.
struct ModelSeries {
  std::string name;
  bool aside = false;  ///< no class of models by itself: it has a figure of its own
  std::vector<ModelResponse> responses;
  ScalingFit alpha;
};

/// The response of one model over depths that double, from its fluctuations.
struct DeepModel {
  std::string series, parameter;
  DeepResponse response;
  std::vector<PeakShapeTest> shapes = {};  ///< of the deepest lags; the form has D and B of waves, where B is known
};

/// What the study has measured.
struct MeasuredModels {
  std::vector<ModelSeries> series;
  std::vector<TractionDepth> tractions;
  std::vector<DeepModel> deep;
};

/// c0 - c against D of all series with two peaks, and the response of the last of each series at the
/// deepest layer. Throws InputError where nothing was measured.
Figure plot_models(const std::vector<ModelSeries>& series, const std::string& study,
                   const std::filesystem::path& run_folder);

/// What correlated noise takes from c^2 and adds to D against Delta^2, beside the theory to second order.
Figure plot_noise(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder);

/// The three-leg model: c against the mean share of the middle leg, beside c0 sqrt(1 - p), and where legs begin to
/// pull.
Figure plot_middle(const std::vector<ModelSeries>& series, const std::vector<TractionDepth>& tractions,
                   const std::filesystem::path& run_folder);

/// What the beads of one pile of the last model of a series carry, under a uniform load.
Figure render_pile_of(const ModelSeries& series, const std::filesystem::path& run_folder);

/// Heavy beads: the thrust ratio over depth, and the response at the deepest layer.
Figure plot_gravity(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder);

/// What the paper's discussion says of classes of models, held against the series measured:
///
///   models-not-elastic    the width of the beads' peaks does not grow as that of an elastic medium;
///   q-model-too-narrow    the q-model has one peak, narrower than the beads' response is wide;
///   models-c-of-D         c0 - c of beads does not follow D as in the theory of stochastic OSL;
///   mean-of-noise         in the three-leg model whose legs push, the mean of its noise alone explains c.
///
/// Each only where what it is about was measured.
std::vector<Claim> judge_models(const std::vector<ModelSeries>& series);

/// The results as they stand in summary.json.
Json models_json(const MeasuredModels& measured);

/// What the sentences of page 1 need beside these: series by the number of their peaks, exponents that are known, and
/// the smallest and largest known share of the slowing that a mean explains.
Json models_page_1(const Json& results);

/// The models that the paper argues with, under one procedure: what the response of each looks like, and which class it
/// belongs to. `measured`: what has been, for tests of the report.
std::unique_ptr<Study> models_study(MeasuredModels measured = {});

}  // namespace granuscope
