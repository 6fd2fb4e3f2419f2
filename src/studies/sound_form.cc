#include "studies/sound_form.h"

#include <cstddef>
#include <numbers>

namespace granuscope {
namespace {

constexpr double longest_of_beads = 0.5;  ///< of k: shorter waves see single beads
constexpr double most_error = 0.25;       ///< of the D of a band
constexpr std::size_t fewest_bands = 3;
constexpr double forgotten = 1e-9;  ///< of a mode: what is left of it counts no more
constexpr int most_steps = 50;

bool tells(const BandOfModes& band) {
  return band.k < longest_of_beads && band.D.known() && band.D.value > 0 &&
         band.D.standard_error < most_error * band.D.value;
}

std::vector<double> depths_of(const DeepResponse& response) {
  std::vector<double> z;
  for (const LagResponse& lag : response.lags) z.push_back(lag.z);
  return z;
}

FormTest spread_from_first(const SoundForm& form, const DeepResponse& response) {
  FormTest test;
  const std::vector<double> z = depths_of(response);
  test.slopes = form.slopes(z, response.spec.lattice.columns);
  test.width_squared = {response.lags.front().width_squared.value};
  for (std::size_t i = 0; i < test.slopes.size(); ++i) {
    test.width_squared.push_back(test.width_squared.back() + test.slopes[i] * (z[i + 1] - z[i]));
  }
  return test;
}

/// chi^2 of the octaves from number `first` on; `variance`: of the slopes of the form.
void hold_against(const DeepResponse& response, std::size_t first, const std::vector<double>& variance,
                  FormTest& test) {
  for (std::size_t i = first; i < test.slopes.size(); ++i) {
    const Estimate& D = response.octaves[i].D;
    test.chi2 += std::pow(D.value - test.slopes[i], 2) / (std::pow(D.standard_error, 2) + variance[i]);
    ++test.octaves;
  }
}

}  // namespace

TwoNumbers least_squares(const std::vector<double>& y, const std::vector<double>& by_first,
                         const std::vector<double>& by_second, const std::vector<double>& weight) {
  double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    aa += weight[i] * by_first[i] * by_first[i];
    ab += weight[i] * by_first[i] * by_second[i];
    bb += weight[i] * by_second[i] * by_second[i];
    ay += weight[i] * by_first[i] * y[i];
    by += weight[i] * by_second[i] * y[i];
  }
  const double determinant = aa * bb - ab * ab;
  return {(ay * bb - by * ab) / determinant, (by * aa - ay * ab) / determinant, bb / determinant, aa / determinant,
          -ab / determinant};
}

std::vector<double> less(const std::vector<double>& one, const std::vector<double>& other, double step) {
  std::vector<double> result;
  for (std::size_t i = 0; i < one.size(); ++i) result.push_back((one[i] - other[i]) / step);
  return result;
}

std::complex<double> SoundForm::mode(double k, double z) const {
  const double fed = B * std::pow(k, 1.5) * z;
  return std::polar(std::exp(-D * k * k * z / 2 - fed), -c * k * z - fed);
}

DoubleGaussian SoundForm::shape(double z, int columns) const {
  LayerSpectrum spectrum;
  spectrum.columns = columns;
  for (int m = 1; m <= (columns - 1) / 2; ++m) {
    const std::complex<double> f = mode(2 * std::numbers::pi * m / columns, z);
    if (std::abs(f) < forgotten) break;
    spectrum.whole.push_back(f.real());
    spectrum.sines.whole.push_back(-f.imag());
  }
  // A wave of the length of the peak tells how wide it is.
  double W = std::sqrt(D * z);
  for (int i = 0; i < 5; ++i) W = std::sqrt((D + 2 * B * std::sqrt(W)) * z);
  auto fitted = weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, {c * z + B * z / std::sqrt(W), W});
  if (!fitted) throw InputError("two Gaussians do not fit to the form of a peak of sound");
  // The fit gives the nearest of the places that are one on the ring; sound is here or at its mirror image.
  const auto on_ring = [&](double x) { return c * z + std::remainder(x - c * z, columns); };
  const double here = on_ring(fitted->peak), mirrored = on_ring(-fitted->peak);
  fitted->peak = std::abs(here - c * z) < std::abs(mirrored - c * z) ? here : mirrored;
  return *fitted;
}

std::vector<double> SoundForm::slopes(const std::vector<double>& z, int columns) const {
  std::vector<double> slopes, squares;
  for (const double at : z) squares.push_back(std::pow(shape(at, columns).width, 2));
  for (std::size_t i = 0; i + 1 < z.size(); ++i) slopes.push_back((squares[i + 1] - squares[i]) / (z[i + 1] - z[i]));
  return slopes;
}

double fed_by(double coupling, double D_field, double c) { return coupling / std::sqrt(8 * D_field * c); }

FormFit fit_waves(const std::vector<BandOfModes>& bands) {
  FormFit fit;
  std::vector<double> D, ones, slow, weight;
  for (const BandOfModes& band : bands) {
    if (!tells(band)) continue;
    D.push_back(band.D.value);
    ones.push_back(1);
    slow.push_back(2 / std::sqrt(band.k));
    weight.push_back(std::pow(band.D.standard_error, -2));
  }
  if (D.size() < fewest_bands) {
    fit.D.reason = fit.B.reason = "D is known of fewer than three bands of waves";
    return fit;
  }
  const TwoNumbers found = least_squares(D, ones, slow, weight);
  fit.D = {found.first, std::sqrt(found.first_variance), {}};
  fit.B = {found.second, std::sqrt(found.second_variance), {}};
  fit.D_B = found.covariance;
  for (std::size_t i = 0; i < D.size(); ++i) {
    fit.chi2 += weight[i] * std::pow(D[i] - found.first - found.second * slow[i], 2);
  }
  fit.degrees_of_freedom = static_cast<int>(D.size()) - 2;
  return fit;
}

FormFit fit_widths(const DeepResponse& response, double D, double B) {
  std::vector<double> y, weight, by_D, by_B, model;
  for (const Replicated& slope : response.slopes_of_width) {
    y.push_back(slope.value);
    weight.push_back(std::pow(estimate(slope).standard_error, -2));
  }
  const std::vector<double> z = depths_of(response);
  const double c = response.c_thrust.value;
  const auto slopes = [&](double of_D, double of_B) {
    return SoundForm{c, of_D, of_B}.slopes(z, response.spec.lattice.columns);
  };
  for (int step = 0; step < most_steps; ++step) {
    const double dD = 1e-3 * D, dB = 1e-3 * std::max(B, 1e-3 * D);
    model = slopes(D, B);
    by_D = less(slopes(D + dD, B), model, dD);
    by_B = less(slopes(D, B + dB), model, dB);
    const TwoNumbers change = least_squares(less(y, model), by_D, by_B, weight);
    D = std::max(0.3 * D, D + change.first);
    B = std::max(0.0, B + change.second);
    if (std::abs(change.first) < 1e-6 * D && std::abs(change.second) < 1e-6 * D) break;
  }
  const auto number = [&](double TwoNumbers::*which, double value) {
    return transform_all(response.slopes_of_width, [&, which, value](const std::vector<double>& others) {
      return value + least_squares(less(others, y), by_D, by_B, weight).*which;
    });
  };
  FormFit fit;
  fit.D = estimate(number(&TwoNumbers::first, D));
  fit.B = estimate(number(&TwoNumbers::second, B));
  fit.D_B = least_squares(y, by_D, by_B, weight).covariance;
  for (std::size_t i = 0; i < y.size(); ++i) fit.chi2 += weight[i] * std::pow(y[i] - model[i], 2);
  fit.degrees_of_freedom = static_cast<int>(y.size()) - 2;
  return fit;
}

FormTest test_waves(const FormFit& fit, const DeepResponse& response) {
  const SoundForm form{response.c_thrust.value, fit.D.value, fit.B.value};
  FormTest test = spread_from_first(form, response);
  const double dD = 1e-3 * form.D, dB = 1e-3 * form.B;
  const std::vector<double> z = depths_of(response);
  const int columns = response.spec.lattice.columns;
  const std::vector<double> by_D = less(SoundForm{form.c, form.D + dD, form.B}.slopes(z, columns), test.slopes, dD),
                            by_B = less(SoundForm{form.c, form.D, form.B + dB}.slopes(z, columns), test.slopes, dB);
  std::vector<double> variance;
  for (std::size_t i = 0; i < by_D.size(); ++i) {
    variance.push_back(std::pow(by_D[i] * fit.D.standard_error, 2) + std::pow(by_B[i] * fit.B.standard_error, 2) +
                       2 * by_D[i] * by_B[i] * fit.D_B);
  }
  hold_against(response, 0, variance, test);
  return test;
}

FormTest test_coupling(const Estimate& B, const DeepResponse& response, SoundForm& form) {
  const std::vector<double> z = depths_of(response);
  const Estimate& first = response.octaves.front().D;
  const auto with = [&](double of_B, double first_slope) {
    SoundForm one{response.c_thrust.value, 0.8 * first_slope, of_B};
    for (int step = 0; step < most_steps; ++step) {
      const double missing = first_slope - one.slopes({z[0], z[1]}, response.spec.lattice.columns).front();
      one.D = std::max(0.3 * one.D, one.D + missing);
      if (std::abs(missing) < 1e-7 * first_slope) break;
    }
    return one;
  };
  form = with(B.value, first.value);
  FormTest test = spread_from_first(form, response);
  const std::vector<double> by_B = spread_from_first(with(B.value + B.standard_error, first.value), response).slopes;
  const std::vector<double> by_first =
      spread_from_first(with(B.value, first.value + first.standard_error), response).slopes;
  std::vector<double> variance;
  for (std::size_t i = 0; i < by_B.size(); ++i) {
    variance.push_back(std::pow(by_B[i] - test.slopes[i], 2) + std::pow(by_first[i] - test.slopes[i], 2));
  }
  hold_against(response, 1, variance, test);
  return test;
}

SpeedTest test_speeds(const FormFit& fit, const DeepResponse& response) {
  SpeedTest test;
  const double c = response.c_thrust.value;
  double products = 0, squares = 0;
  for (const BandOfModes& band : response.bands) {
    if (!tells(band) || !band.c.known()) continue;
    const double faster = std::sqrt(band.k), measured = band.c.value - c, said = fit.B.value * faster;
    const double variance = std::pow(band.c.standard_error, 2), of_form = std::pow(fit.B.standard_error * faster, 2);
    products += measured * said / variance;
    squares += said * said / variance;
    test.chi2 += std::pow(measured - said, 2) / (variance + of_form);
    test.chi2_of_none += measured * measured / variance;
    ++test.bands;
  }
  if (squares == 0) {
    test.ratio.reason = "the speed of no band of waves is known";
    return test;
  }
  const double ratio = products / squares;
  test.ratio = {ratio, std::hypot(1 / std::sqrt(squares), ratio * fit.B.standard_error / fit.B.value), {}};
  return test;
}

}  // namespace granuscope
