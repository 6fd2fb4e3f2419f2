#include "analysis/line_fit.h"

#include <Eigen/QR>
#include <stdexcept>

namespace granuscope {
namespace {

/// Coefficients of the polynomial of degree `terms` - 1.
Eigen::VectorXd fit_polynomial(Eigen::Index terms, std::span<const double> x, std::span<const double> y,
                               std::span<const double> weights) {
  const auto size = static_cast<Eigen::Index>(x.size());
  if (size < terms || y.size() != x.size() || weights.size() != x.size()) {
    throw std::logic_error("a polynomial needs as many points as it has coefficients, each with its weight");
  }
  const Eigen::Map<const Eigen::ArrayXd> positions(x.data(), size);
  const Eigen::ArrayXd root = Eigen::Map<const Eigen::ArrayXd>(weights.data(), size).sqrt();
  Eigen::MatrixXd design(size, terms);
  Eigen::ArrayXd column = root;
  for (Eigen::Index term = 0; term < terms; ++term) {
    design.col(term) = column.matrix();
    column *= positions;
  }
  const Eigen::VectorXd target = (Eigen::Map<const Eigen::ArrayXd>(y.data(), size) * root).matrix();
  return design.colPivHouseholderQr().solve(target);
}

}  // namespace

Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights) {
  const Eigen::VectorXd solution = fit_polynomial(2, x, y, weights);
  return {solution(0), solution(1)};
}

Parabola fit_parabola(std::span<const double> x, std::span<const double> y, std::span<const double> weights) {
  const Eigen::VectorXd solution = fit_polynomial(3, x, y, weights);
  return {solution(0), solution(1), solution(2)};
}

}  // namespace granuscope
