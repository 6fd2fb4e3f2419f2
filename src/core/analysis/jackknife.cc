#include "analysis/jackknife.h"

#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "analysis/mean_response.h"
#include "ensemble/ensemble_spec.h"
#include "sampling/polytope.h"
#include "support/plain_text.h"

namespace granuscope {
std::string value_with_error(const Estimate& number) { return value_with_error(number.value, number.standard_error); }

std::string in_words(const Estimate& number) { return number.known() ? value_with_error(number) : "unknown"; }

Estimate estimate(const Replicated& number, const std::string& reason_if_unknown) {
  const auto blocks = static_cast<double>(number.without_block.size());
  // Summing distances from one entry keeps the spread of equal entries exactly 0.
  const double origin = number.without_block.empty() ? 0 : number.without_block.front();
  double mean = origin;
  for (double replicate : number.without_block) mean += (replicate - origin) / blocks;
  double spread = 0;
  for (double replicate : number.without_block) spread += (replicate - mean) * (replicate - mean);
  Estimate result;
  if (!std::isfinite(number.value) || !std::isfinite(spread)) {
    result.reason = reason_if_unknown;
    return result;
  }
  result.value = number.value;
  result.standard_error = std::sqrt((blocks - 1) / blocks * spread);
  return result;
}

Replicated transform_all(const std::vector<Replicated>& numbers,
                         const std::function<double(const std::vector<double>&)>& f) {
  std::vector<double> arguments(numbers.size());
  const auto fill = [&](auto&& pick) {
    for (std::size_t i = 0; i < numbers.size(); ++i) arguments[i] = pick(numbers[i]);
    return f(arguments);
  };
  Replicated result;
  result.value = fill([](const Replicated& r) { return r.value; });
  const std::size_t blocks = numbers.empty() ? 0 : numbers.front().without_block.size();
  for (std::size_t b = 0; b < blocks; ++b) {
    result.without_block.push_back(fill([b](const Replicated& r) { return r.without_block[b]; }));
  }
  return result;
}

Replicated mean_of(const std::vector<Replicated>& numbers) {
  return transform_all(numbers, [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  });
}

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

namespace {

/// Beside the scatter of all points together, scatter this small is rounding.
constexpr double rounding_of_lines = 1e-10;

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
  Eigen::MatrixXd across = Eigen::MatrixXd::Identity(size, size);
  if (parameters > 0) {
    const Eigen::MatrixXd rotation = Eigen::HouseholderQR<Eigen::MatrixXd>(design).householderQ();
    across = rotation.rightCols(size - parameters).transpose();
  }
  const Eigen::MatrixXd deviations = replicates.colwise() - replicates.rowwise().mean();
  const Eigen::MatrixXd scatter = across * deviations;
  const auto n = static_cast<double>(blocks), m = static_cast<double>(y.size());
  const Eigen::MatrixXd covariance = (n - 1) / n * scatter * scatter.transpose();
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  // A direction without scatter of its own leaves the factor with a pivot of rounding.
  const double least = rounding_of_lines * deviations.norm();
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

double chance_of(const LineTest& test, std::size_t blocks) {
  const double n = static_cast<double>(blocks), d = test.degrees_of_freedom;
  if (!(d > 0) || !std::isfinite(test.chi2)) return std::numeric_limits<double>::quiet_NaN();
  return gsl_cdf_fdist_Q(test.chi2 / d * (n - d) / (n - test.points), d, n - d);
}

FlatTest test_flat_law(const BlockSums& sums) {
  FlatTest test;
  if (!sums.quantities.contains(flat_tests.front())) return test;
  std::vector<Replicated> means;
  for (const char* name : flat_tests) {
    std::vector<Replicated> layers;
    for (std::size_t row = 0; row < sums.layers.size(); ++row) layers.push_back(block_mean(sums, name, row));
    means.push_back(mean_of(layers));
    test.means.push_back(estimate(means.back()));
  }
  const auto whole = [](std::uint64_t samples) { return samples % PolytopeSampler::group == 0; };
  test.all_zero.reason = "the last chain is incomplete: give a multiple of eight samples";
  if (std::ranges::all_of(sums.count, whole)) test.all_zero = test_curve(0, std::vector<double>(means.size()), means);
  test.all_zero.chi2 *= sums.scatter * sums.scatter;  // whether it is large enough is told by other numbers
  test.chance = chance_of(test.all_zero, sums.count.size());
  return test;
}

namespace {

/// Scatter below this share of the mean square is rounding.
constexpr double rounding_of_squares = 1e-20;

/// Infinite if nothing scatters.
double effective_by(const BlockSums& sums, const QuantitySums& quantity, double count) {
  const std::size_t blocks = sums.count.size(), layers = sums.layers.size();
  double of_one = 0, of_mean = 0;
  for (std::size_t layer = 0; layer < layers; ++layer) {
    double sum = 0, squares = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      sum += quantity.sum[b * layers + layer];
      squares += quantity.sum_of_squares[b * layers + layer];
    }
    const double mean = sum / count, variance = squares / count - mean * mean;
    if (!(variance > rounding_of_squares * squares / count)) continue;
    Replicated replicated{mean, {}};
    for (std::size_t b = 0; b < blocks; ++b) {
      replicated.without_block.push_back((sum - quantity.sum[b * layers + layer]) /
                                         (count - static_cast<double>(sums.count[b])));
    }
    of_one += variance;
    of_mean += std::pow(estimate(replicated).standard_error, 2);
  }
  return of_one > 0 ? of_one / of_mean : std::numeric_limits<double>::infinity();
}

}  // namespace

Estimate effective_samples(const BlockSums& sums) {
  Estimate result;
  if (sums.blocks() < min_blocks) {
    result.reason = "too few blocks tell how far the piles depend on each other";
    return result;
  }
  const auto count = static_cast<double>(sums.samples());
  double least = std::numeric_limits<double>::infinity();
  for (const char* name : {"thrust", "weight_variance"}) {
    least = std::min(least, effective_by(sums, sums.quantities.at(name), count));
  }
  if (!std::isfinite(least)) {
    result.reason = "no pile was completed, or all are the same";
    return result;
  }
  result.value = least;
  result.standard_error = least * std::sqrt(2.0 / (sums.blocks() - 1));
  return result;
}

}  // namespace granuscope
