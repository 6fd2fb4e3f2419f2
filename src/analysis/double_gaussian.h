#pragma once
#include <span>
#include <vector>

namespace granuscope {

/// The paper's G(x): two mirror Gaussians of area 1/2 each at +-peak, integrated over the width of a bead, on a ring.
struct DoubleGaussian {
  double peak = 0;   ///< x_p, bead diameters
  double width = 1;  ///< W, bead diameters
};

/// Value at each bead centre x (shape of `x`, bead diameters) on a ring of `columns`; sums to 1 over the ring.
std::vector<double> evaluate(const DoubleGaussian& shape, std::span<const double> x, int columns);

/// The largest value of the two Gaussians per bead diameter (not integrated over a bead), on an open line.
double largest_value(const DoubleGaussian& shape);

/// One Fourier mode of the sampled shape and its derivatives.
struct ModeValue {
  double value, by_peak, by_width;
};

/// sum_j G(x_j) cos(k x_j) over the beads of one layer, k = 2 pi mode / columns, for beads at integer x
/// (`half_shifted` false) or half-integer x (true). Exact: with q = k + 2 pi l,
///   sum over l of (-1)^(l half_shifted) cos(q x_p) exp(-q^2 W^2 / 2) sin(q/2)/(q/2),
/// the sum running over the aliases that sampling at bead centres folds onto k.
ModeValue fourier_mode(const DoubleGaussian& shape, int mode, int columns, bool half_shifted);

/// fourier_mode for the modes 1 .. modes.size(), the form the fits use: angles by rotation instead of one sine and
/// cosine for each alias. Agrees with fourier_mode to 1e-12. `sines`: as many, or none of them: sum_j G_+(x_j)
/// sin(k x_j) of the Gaussian G_+ at +peak, of area 1; the same formula with sin(q x_p).
void fourier_modes(const DoubleGaussian& shape, int columns, bool half_shifted, std::span<ModeValue> modes,
                   std::span<ModeValue> sines = {});

}  // namespace granuscope
