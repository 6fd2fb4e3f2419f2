#include "theory.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "model/lattice.h"

namespace granuscope {
namespace {

NoiseTheory theory_of(const StochasticOslSpec& spec, double spacing) {
  NoiseTheory theory;
  theory.c0 = tan30;
  theory.disorder = spec.disorder;
  // g_x falls by 1/width over the width of a cell, g_z(u/c0) = 1 - u/reach.
  const double width = spec.cell_columns, reach = theory.c0 * spec.cell_rows * spacing, u = std::min(width, reach);
  theory.cell = width;
  theory.wide.kappa = (u - u * u / (2 * reach)) / width;
  theory.wide.spreading = theory.c0 * (u * u / 2 - u * u * u / (3 * reach)) / width;
  const double both = u - u * u / 2 * (1 / reach + 1 / width) + u * u * u / (3 * reach * width);
  theory.narrow = {theory.wide.kappa / 2 + 0.25, theory.c0 / 2 * both};
  return theory;
}

/// The share that the middle leg of one bead carries beyond p enters the rows below as b = (F_t, push) = (1, 0) below
/// it and (-1/2, -+1/2) on either side. What of this comes back as weight m rows on meets noise that is still the same
/// with g_x g_z: for slow fields both noises together are a change of p by Delta_p^2 sum_m q_m, q_m = g_z(m) sum_x
/// g_x(x) h_m(x), at a delay of m rows, by which a peak that moves is spread.
NoiseTheory theory_of(const ThreeLegSpec& spec, double spacing) {
  const double p = spec.middle;
  NoiseTheory theory;
  theory.c0 = tan30 * std::sqrt(1 - p);
  theory.D0 = p / (2 * spacing);
  theory.disorder = spec.noise / std::sqrt(3.0) / (1 - p);
  theory.cell = spec.cell_columns;
  const int rows = spec.cell_rows, middle = rows + 1;
  std::vector<double> weight(2 * static_cast<std::size_t>(middle) + 1), push(weight.size());
  const auto at = [middle](std::vector<double>& row, int x) -> double& {
    const int place = middle + x;
    return row[static_cast<std::size_t>(place)];
  };
  at(weight, 0) = 1;
  at(weight, 1) = at(weight, -1) = at(push, 1) = -0.5;
  at(push, -1) = 0.5;
  double shift = 0, delayed = 0;  // of p, over Delta_p^2
  for (int m = 1; m < rows; ++m) {
    double q = 0;
    for (int x = -std::min(middle, spec.cell_columns); x <= std::min(middle, spec.cell_columns); ++x) {
      q += (1 - static_cast<double>(m) / rows) * (1 - std::abs(x) / static_cast<double>(spec.cell_columns)) *
           at(weight, x);
    }
    shift += q;
    delayed += (m + 0.5) * q;
    std::vector<double> weight_below(weight.size()), push_below(weight.size());
    for (int x = -m; x <= m; ++x) {
      const double right = ((1 - p) * at(weight, x) + at(push, x)) / 2;
      const double left = ((1 - p) * at(weight, x) - at(push, x)) / 2;
      at(weight_below, x) += p * at(weight, x);
      at(weight_below, x + 1) += right, at(push_below, x + 1) += right;
      at(weight_below, x - 1) += left, at(push_below, x - 1) -= left;
    }
    weight = weight_below;
    push = push_below;
  }
  theory.wide = {shift * (1 - p), delayed * (1 - p) * (1 - p) / spacing};
  return theory;
}

}  // namespace

double NoiseTheory::c(double width) const { return c0 * std::sqrt(1 - shift(width).kappa * disorder * disorder); }

NoiseTheory noise_theory(const ModelSpec& model) {
  const double spacing = rows_of(model).spacing;
  if (model.name == ModelName::stochastic_osl) return theory_of(model.stochastic_osl, spacing);
  if (model.name == ModelName::three_leg && model.three_leg.law == MiddleLaw::free) {
    return theory_of(model.three_leg, spacing);
  }
  throw std::logic_error("a model without a theory of its noise was asked for it");
}

}  // namespace granuscope
