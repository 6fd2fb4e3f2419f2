#pragma once
#include <filesystem>
#include <functional>

#include "model/pile.h"
#include "model/pile_view.h"

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

}  // namespace granuscope
