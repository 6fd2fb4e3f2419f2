#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "model/lattice.h"
#include "model/pile.h"
#include "storage/hdf5_file.h"

namespace granuscope {
/// Writes a pile as HDF5: float64 datasets V_R, V_L, H_R, H_L [layers, columns], load [columns]; attributes mu, law,
/// seed, sample, units. The same pile gives the same bytes. Throws EnvironmentError (disk full, no permission).
void write_pile(const std::filesystem::path& file, const Pile& pile);

/// Reads a pile. Throws InputError for a missing, damaged or foreign file, wrong shapes, or numbers that are not
/// finite.
Pile read_pile(const std::filesystem::path& file);

/// Reads some layers and beads of a pile, those that `choose` names for its lattice, and nothing else of its forces;
/// all shapes are checked nevertheless. Throws InputError as read_pile().
PilePart read_pile_part(const std::filesystem::path& file, const std::function<PileRange(const Lattice&)>& choose);

/// Layers that a band has at least, so that neighbouring looks at a pile meet in one.
inline constexpr int band_layers = 320;
/// Forces that a band may take more than that, in bytes: as much of a pile is read once and kept.
inline constexpr std::size_t band_bytes = std::size_t{48} << 20;

/// The layers of a stored pile, of the range that `choose` names for its lattice. Only a band of them is in memory:
/// at least band_layers, and as many as `bytes` hold if that is more. The lattice, load and all shapes are read and
/// checked now, forces when they are looked at. Throws InputError as read_pile(), hold() too.
std::unique_ptr<PileLayers> open_pile_layers(const std::filesystem::path& file,
                                             const std::function<PileRange(const Lattice&)>& choose,
                                             std::size_t bytes = band_bytes);

/// For whoever reads a file without this program: /z [layers], the depth of each of these layers, and /x [2, columns],
/// where the beads of even and of odd layers lie from the overloaded one, both in bead diameters; with their units.
/// Returns the numbers of /x, where there is one, and of /z.
std::vector<double> write_lattice_axes(Hdf5Writer& writer, int columns, std::span<const int> layers,
                                       const RowGeometry& rows = {});

/// Attributes "units" and "axes" of a dataset.
void describe_dataset(Hdf5Writer& writer, const std::string& path, std::string_view units, std::string_view axes);

}  // namespace granuscope
