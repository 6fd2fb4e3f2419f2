#include "analysis/line_test.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <stdexcept>

namespace granuscope {
namespace {

/// Beside the scatter of all points together, scatter this small is rounding.
constexpr double rounding = 1e-10;

/// Of a curve with so many parameters: the powers of x below that are its terms.
LineTest test_curve(int parameters, std::span<const double> x, const std::vector<Replicated>& y) {
  if (x.size() != y.size()) throw std::logic_error("a curve is tested with as many x as y");
  const std::size_t blocks = y.empty() ? 0 : y.front().without_block.size();
  LineTest test;
  test.points = static_cast<int>(y.size());
  if (test.points <= parameters) {
    test.reason = parameters == 2 ? "a line goes through any two points" : "a parabola goes through any three points";
    return test;
  }
  if (2 * y.size() > blocks) {
    test.reason = fmt::format("{} blocks give no reliable covariance of {} points", blocks, y.size());
    return test;
  }
  const auto size = static_cast<Eigen::Index>(y.size());
  const auto count = static_cast<Eigen::Index>(blocks);
  Eigen::MatrixXd design(size, parameters), replicates(size, count);
  Eigen::VectorXd values(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    for (int power = 0; power < parameters; ++power) design(i, power) = std::pow(x[k], power);
    values(i) = y[k].value;
    for (Eigen::Index b = 0; b < count; ++b) replicates(i, b) = y[k].without_block[static_cast<std::size_t>(b)];
  }
  // The directions in which a point can leave the curve.
  const Eigen::MatrixXd rotation = Eigen::HouseholderQR<Eigen::MatrixXd>(design).householderQ();
  const Eigen::MatrixXd across = rotation.rightCols(size - parameters).transpose();
  const Eigen::MatrixXd deviations = replicates.colwise() - replicates.rowwise().mean();
  const Eigen::MatrixXd scatter = across * deviations;
  const auto n = static_cast<double>(blocks), m = static_cast<double>(y.size());
  const Eigen::MatrixXd covariance = (n - 1) / n * scatter * scatter.transpose();
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  // A direction without scatter of its own leaves the factor with a pivot of rounding.
  const double least = rounding * deviations.norm();
  if (factor.info() != Eigen::Success || !(factor.matrixLLT().diagonal().minCoeff() > least)) {
    test.reason = "the joint covariance of the points cannot be inverted";
    return test;
  }
  test.chi2 = (n - m) / (n - 1) * factor.matrixL().solve(across * values).squaredNorm();
  test.degrees_of_freedom = test.points - parameters;
  return test;
}

}  // namespace

LineTest test_line(std::span<const double> x, const std::vector<Replicated>& y) { return test_curve(2, x, y); }

LineTest test_parabola(std::span<const double> x, const std::vector<Replicated>& y) { return test_curve(3, x, y); }

}  // namespace granuscope
