#include "storage/lattice_axes.h"

#include <algorithm>
#include <vector>

#include "model/lattice.h"

namespace granuscope {

void describe_dataset(Hdf5Writer& writer, const std::string& path, std::string_view units, std::string_view axes) {
  writer.attribute(path, "units", units);
  writer.attribute(path, "axes", axes);
}

void write_lattice_axes(Hdf5Writer& writer, int columns, std::span<const int> layers, const RowGeometry& rows) {
  std::vector<double> z, x;
  for (const int layer : layers) z.push_back(rows.depth(layer));
  writer.dataset("/z", {z.size()}, z);
  describe_dataset(writer, "/z", "bead diameters", "layer");
  if (columns < fewest_columns) return;  // nothing by columns is stored
  const Lattice lattice({.columns = columns, .layers = 2});
  for (const int parity : {0, 1}) {
    for (int bead = 0; bead < columns; ++bead) x.push_back(lattice.x(rows.shifted(parity) ? 1 : 0, bead));
  }
  writer.dataset("/x", {2, static_cast<std::uint64_t>(columns)}, x);
  describe_dataset(writer, "/x", "bead diameters", "layer modulo 2, column");
  writer.attribute("/x", "overloaded_column", static_cast<std::uint64_t>(lattice.middle()));
}

}  // namespace granuscope
