#pragma once
#include <span>

#include "model/lattice.h"
#include "storage/hdf5_writer.h"

namespace granuscope {

/// For whoever reads a file without this program: /z [layers], the depth of each of these layers, and /x [2, columns],
/// where the beads of even and of odd layers lie from the overloaded one, both in bead diameters; with their units.
void write_lattice_axes(Hdf5Writer& writer, int columns, std::span<const int> layers, const RowGeometry& rows = {});

/// Attributes "units" and "axes" of a dataset.
void describe_dataset(Hdf5Writer& writer, const std::string& path, std::string_view units, std::string_view axes);

}  // namespace granuscope
