#include "plot/response_field.h"

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "analysis/dispersion.h"
#include "analysis/double_gaussian.h"
#include "model/lattice.h"
#include "render/layout.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {

namespace {

/// The fitted two Gaussians at a depth, if they have a width there.
std::optional<DoubleGaussian> fitted_at(const Transport& transport, double z) {
  if (!transport.c.known() || !transport.position_offset.known()) return std::nullopt;
  if (!transport.D.known() || !transport.width_offset.known()) return std::nullopt;
  const double square = transport.width_offset.value + transport.D.value * z;
  if (!(square > 0)) return std::nullopt;
  return DoubleGaussian{transport.position_offset.value + transport.c.value * z, std::sqrt(square)};
}

double middle_of(const FieldRow& row, std::size_t k) { return row.left_of(k) + 0.5 * row.cell; }

/// What the fit makes of a row; nothing if it makes nothing of it.
std::vector<double> fitted_row(const FieldRow& row, const Transport& transport) {
  const auto shape = fitted_at(transport, row.z);
  if (!shape) return {};
  std::vector<double> x;
  for (std::size_t k = 0; k < row.values.size(); ++k) x.push_back(middle_of(row, k) / row.cell);
  std::vector<double> fit = evaluate({shape->peak / row.cell, shape->width / row.cell}, x, static_cast<int>(x.size()));
  for (double& one : fit) one /= row.cell;
  return fit;
}

}  // namespace

std::string response_field_csv(const Field& measured, const Transport& transport) {
  CsvTable table({"x: bead diameters", "z: bead diameters", "P: 1/bead diameter", "fit: 1/bead diameter"});
  for (const FieldRow& row : measured.rows) {
    const std::vector<double> fit = fitted_row(row, transport);
    for (std::size_t k = 0; k < row.values.size(); ++k) {
      table.add_row(
          {middle_of(row, k), row.z, row.values[k], fit.empty() ? std::numeric_limits<double>::quiet_NaN() : fit[k]});
    }
  }
  return table.text();
}

void put_fit_on_the_right(Field& field, const Transport& transport) {
  // Up to the surface, above the first layer that was recorded, there is the fit alone.
  if (field.rows.size() > 1) {
    const FieldRow first = field.rows.front();
    const double gap = field.rows[1].z - first.z;
    std::vector<FieldRow> above;
    for (int k = 1; first.z - k * gap > 0; ++k) {
      above.push_back({first.z - k * gap, first.x0, std::vector<double>(first.values.size(), 0.0), first.cell});
    }
    field.rows.insert(field.rows.begin(), above.rbegin(), above.rend());
  }
  for (FieldRow& row : field.rows) {
    const std::vector<double> fit = fitted_row(row, transport);
    for (std::size_t k = 0; k < fit.size(); ++k) {
      if (middle_of(row, k) > 0) row.values[k] = fit[k];
    }
  }
}

MeasuredEnsemble open_response(const std::string& file, const std::string& configuration) {
  MeasuredEnsemble ensemble;
  ensemble.record = open_ensemble(file);
  const std::vector<int>& layers = ensemble.record.sums.layers;
  ensemble.spec = ensemble_configured(configuration);
  const int columns = ensemble.spec.lattice.columns, shown = layers.empty() ? 1 : layers.back() + 1;
  const std::map<std::string, int> widths{{"response", columns},
                                          {"weight", columns},
                                          {"moved_weight", response_columns(ensemble.spec)},
                                          {"correlation", columns},
                                          {"propagation", 2 * columns}};
  bool known = ensemble.spec.lattice.layers >= shown && columns >= 2, held = false;
  for (const auto& [name, sums] : ensemble.record.sums.quantities) {
    const auto width = widths.find(name);
    if (width == widths.end()) continue;
    held = true;
    known = known && sums.width == width->second;
  }
  if (!known || !held) {
    throw InputError(
        "{}: it has no response of as many columns and layers as its configuration says, so that there is nothing to "
        "be shown; name an ensemble whose profiles are recorded, of any estimator, or make the file again",
        file);
  }
  const BlockSums& sums = ensemble.record.sums;
  if (holds_propagation(sums) && propagated_modes(sums, layers.size() - 1).cosines.whole.empty()) {
    throw InputError(
        "{}: nothing fluctuates in its piles, which the estimator fluctuation would follow; name an ensemble of "
        "another estimator",
        file);
  }
  ensemble.spec.lattice.layers = shown;
  return ensemble;
}

int leftmost_bead(const Lattice& lattice, int row) {
  int leftmost = 0;
  for (int bead = 1; bead < lattice.columns(); ++bead) {
    if (lattice.x(row, bead) < lattice.x(row, leftmost)) leftmost = bead;
  }
  return leftmost;
}

Field response_field(const MeasuredEnsemble& ensemble, const Transport& transport) {
  const Lattice lattice({response_columns(ensemble.spec), 2});
  const RowGeometry rows = ensemble.record.sums.rows;
  const auto columns = static_cast<std::size_t>(lattice.columns());
  Field field;
  field.key_title = label("field");
  const std::vector<int>& layers = ensemble.record.sums.layers;
  for (std::size_t row = 0; row < layers.size(); ++row) {
    const BlockMeans response = mean_response(ensemble.record.sums, row, ensemble.spec.response.overload);
    FieldRow cells;
    cells.z = rows.depth(layers[row]);
    const int kind_of_row = rows.shifted(layers[row]) ? 1 : 0;
    const int left = leftmost_bead(lattice, kind_of_row);
    const auto leftmost = static_cast<std::size_t>(left);
    cells.cell = rows.pitch;
    cells.x0 = (lattice.x(kind_of_row, left) - 0.5) * rows.pitch;
    for (std::size_t k = 0; k < columns; ++k)
      cells.values.push_back(response.whole[(leftmost + k) % columns] / rows.pitch);
    field.rows.push_back(std::move(cells));
  }
  if (field.rows.empty()) return field;
  const double first = rows.depth(0), last = field.rows.back().z;
  const auto known = [](const Estimate& estimate) { return std::isfinite(estimate.value); };
  if (!known(transport.c) || !known(transport.position_offset)) return field;
  const bool widths = known(transport.D) && known(transport.width_offset);
  constexpr int pieces = 60;
  for (const double side : {-1.0, 1.0}) {
    OverlayLine ray, inner, outer;
    inner.dashed = outer.dashed = true;
    for (int k = 0; k <= pieces; ++k) {
      const double z = first + (last - first) * k / pieces;
      const double x = transport.position_offset.value + transport.c.value * z;
      if (x < 0) continue;
      ray.points.push_back({side * x, z});
      const double square = widths ? transport.width_offset.value + transport.D.value * z : 0;
      if (square <= 0) continue;
      inner.points.push_back({side * (x - std::sqrt(square)), z});
      outer.points.push_back({side * (x + std::sqrt(square)), z});
    }
    field.lines.push_back(ray);
    if (inner.points.size() > 1) field.lines.insert(field.lines.end(), {inner, outer});
  }
  return field;
}

}  // namespace granuscope
