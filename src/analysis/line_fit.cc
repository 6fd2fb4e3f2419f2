#include "analysis/line_fit.h"

#include <Eigen/Dense>
#include <stdexcept>

namespace granuscope {

Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights) {
  if (x.size() < 2 || y.size() != x.size() || weights.size() != x.size()) {
    throw std::logic_error("a line needs two points or more, each with its weight");
  }
  const auto size = static_cast<Eigen::Index>(x.size());
  const Eigen::ArrayXd root = Eigen::Map<const Eigen::ArrayXd>(weights.data(), size).sqrt();
  Eigen::MatrixXd design(size, 2);
  design.col(0) = root.matrix();
  design.col(1) = (Eigen::Map<const Eigen::ArrayXd>(x.data(), size) * root).matrix();
  const Eigen::VectorXd target = (Eigen::Map<const Eigen::ArrayXd>(y.data(), size) * root).matrix();
  const Eigen::Vector2d solution = design.colPivHouseholderQr().solve(target);
  return {solution(0), solution(1)};
}

}  // namespace granuscope
