#include "plot/response_field.h"

#include <cmath>
#include <utility>

#include "analysis/mean_response.h"
#include "model/lattice.h"
#include "render/labels.h"

namespace granuscope {

Field response_field(const MeasuredEnsemble& ensemble, const Transport& transport) {
  const Lattice lattice(ensemble.spec.lattice);
  const auto columns = static_cast<std::size_t>(lattice.columns());
  Field field;
  field.key_title = label("field");
  const std::vector<int>& layers = ensemble.record.sums.layers;
  for (std::size_t row = 0; row < layers.size(); ++row) {
    const BlockMeans response = mean_response(ensemble.record.sums, row, ensemble.spec.response.overload);
    FieldRow cells;
    cells.z = Lattice::depth(layers[row]);
    std::size_t leftmost = 0;
    for (std::size_t bead = 1; bead < columns; ++bead) {
      const auto x = [&](std::size_t i) { return lattice.x(layers[row], static_cast<int>(i)); };
      if (x(bead) < x(leftmost)) leftmost = bead;
    }
    cells.x0 = lattice.x(layers[row], static_cast<int>(leftmost)) - 0.5;
    for (std::size_t k = 0; k < columns; ++k) cells.values.push_back(response.whole[(leftmost + k) % columns]);
    field.rows.push_back(std::move(cells));
  }
  if (field.rows.empty()) return field;
  const double first = field.rows.front().z, last = field.rows.back().z;
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
