#include "export/field_export.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "analysis/jackknife.h"
#include "export/vtk_file.h"
#include "model/lattice.h"
#include "plot/response_field.h"
#include "support/plain_text.h"
#include "support/progress.h"

namespace granuscope {
namespace {

/// P of one recorded layer from the left end of the ring on, with standard errors, [columns] each.
struct FieldLine {
  double x = 0;  ///< of the first one, in columns
  std::vector<double> values, errors;
};

FieldLine line_at(const MeasuredEnsemble& ensemble, std::size_t row) {
  throw_if_interrupted();
  const BlockSums& sums = ensemble.record.sums;
  const BlockMeans response = mean_response(sums, row, ensemble.spec.response.overload);
  const Lattice lattice({response_columns(ensemble.spec), 2});
  const int parity = sums.rows.shifted(sums.layers[row]) ? 1 : 0;
  const int leftmost = leftmost_bead(lattice, parity);
  FieldLine line{lattice.x(parity, leftmost), {}, {}};
  for (int k = 0; k < lattice.columns(); ++k) {
    const auto bead = static_cast<std::size_t>((leftmost + k) % lattice.columns());
    Replicated one{response.whole[bead], {}};
    for (const std::vector<double>& block : response.without_block) one.without_block.push_back(block[bead]);
    line.values.push_back(one.value / sums.rows.pitch);
    line.errors.push_back(estimate(one).standard_error / sums.rows.pitch);
  }
  return line;
}

void write_csv(const MeasuredEnsemble& ensemble, const std::filesystem::path& target, const Accept& accept) {
  const BlockSums& sums = ensemble.record.sums;
  StreamedFile file(target);
  const CsvTable head(
      {"x: bead diameters", "z: bead diameters", "P: 1/bead diameter", "standard_error: 1/bead diameter"});
  accept(head.text());
  file.append(head.text());
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const FieldLine line = line_at(ensemble, row);
    std::string text;
    const auto cell = [](double number) { return std::isfinite(number) ? exact(number) : std::string("NaN"); };
    for (std::size_t k = 0; k < line.values.size(); ++k) {
      text += fmt::format("{},{},{},{}\n", exact(sums.rows.pitch * (line.x + static_cast<double>(k))),
                          exact(sums.rows.depth(sums.layers[row])), cell(line.values[k]), cell(line.errors[k]));
    }
    file.append(text);
  }
  file.commit();
}

void write_vti(const MeasuredEnsemble& ensemble, const std::filesystem::path& target, const std::string& comment) {
  const BlockSums& sums = ensemble.record.sums;
  const std::vector<int>& layers = sums.layers;
  int step = 0;  // between rows of the image, in layers
  for (std::size_t row = 1; row < layers.size(); ++row) step = std::gcd(step, layers[row] - layers[row - 1]);
  if (step == 0) step = 1;
  const std::uint64_t rows = static_cast<std::uint64_t>((layers.back() - layers.front()) / step) + 1;
  const int columns = response_columns(ensemble.spec);
  const std::uint64_t halves = 2 * static_cast<std::uint64_t>(columns);
  const double height = step * sums.rows.spacing;

  VtkFile vtk(target, "ImageData");
  const std::string extent = fmt::format("0 {} 0 {} 0 0", halves, rows);
  std::string inside = fmt::format(
      "<ImageData WholeExtent=\"{0}\" Origin=\"{1} {2} 0\" Spacing=\"{4} {3} 1\">\n<Piece Extent=\"{0}\">\n"
      "<PointData/>\n<CellData Scalars=\"P\">\n",
      extent, exact(-0.5 * columns * sums.rows.pitch), exact(-sums.rows.depth(layers.back()) - height / 2),
      exact(height), exact(0.5 * sums.rows.pitch));
  for (const char* name : {"P", "standard_error"}) inside += vtk.array(name, "Float64", 1, halves * rows);
  vtk.begin(comment, inside + "</CellData>\n</Piece>\n</ImageData>\n");

  const std::vector<double> unknown(halves, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0, next = 0; row < rows; ++row) {  // from the surface, which is the last row of the image
    const std::uint64_t first = (rows - 1 - row) * halves;
    if (layers[next] != layers.front() + static_cast<int>(row) * step) {
      for (const std::size_t array : {0, 1}) vtk.put<double>(array, first, unknown);
      continue;
    }
    const FieldLine line = line_at(ensemble, next++);
    // Where the first bead begins, in halves from the ring's end; if half of it lies across the seam, at the other end.
    const std::size_t left = (halves + static_cast<std::size_t>(2 * line.x + columns) - 1) % halves;
    for (const auto& [array, numbers] : {std::pair{std::size_t{0}, &line.values}, {std::size_t{1}, &line.errors}}) {
      std::vector<double> cells(halves);
      for (std::size_t half = 0; half < halves; ++half) cells[(left + half) % halves] = (*numbers)[half / 2];
      vtk.put<double>(array, first, cells);
    }
  }
  vtk.commit();
}

}  // namespace

void export_field(const MeasuredEnsemble& ensemble, FieldFormat format, const std::filesystem::path& file,
                  const std::string& origin, const Accept& accept) {
  if (format == FieldFormat::csv) return write_csv(ensemble, file, accept);
  accept("<?xml");
  write_vti(ensemble, file, origin + "; lengths in bead diameters, y up");
}

}  // namespace granuscope
