#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace granuscope {

/// (one - other)/step.
inline std::vector<double> difference(const std::vector<double>& one, const std::vector<double>& other,
                                      double step = 1) {
  std::vector<double> result;
  for (std::size_t i = 0; i < one.size(); ++i) result.push_back((one[i] - other[i]) / step);
  return result;
}

/// The step in two parameters that takes the residuals, data less model, away best by least squares. Of derivatives of
/// the model.
inline std::array<double, 2> best_step(const std::vector<double>& residual, const std::vector<double>& by_first,
                                       const std::vector<double>& by_second, const std::vector<double>& weight) {
  double aa = 0, ab = 0, bb = 0, ar = 0, br = 0;
  for (std::size_t i = 0; i < residual.size(); ++i) {
    aa += weight[i] * by_first[i] * by_first[i];
    ab += weight[i] * by_first[i] * by_second[i];
    bb += weight[i] * by_second[i] * by_second[i];
    ar += weight[i] * by_first[i] * residual[i];
    br += weight[i] * by_second[i] * residual[i];
  }
  const double determinant = aa * bb - ab * ab;
  return {(ar * bb - br * ab) / determinant, (br * aa - ar * ab) / determinant};
}

}  // namespace granuscope
