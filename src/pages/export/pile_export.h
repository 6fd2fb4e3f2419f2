#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "model/pile.h"

namespace granuscope {
/// How other programs read a pile. Floor and seam: see NetworkContact.
enum class PileFormat {
  vtu,         ///< VTK: beads as points, contacts as lines, all numbers; y up
  dump_local,  ///< LAMMPS and LIGGGHTS: contacts as `dump local`, beads as `dump custom`; y up, numbers from 1
  pegs,        ///< PeGS2: Adjacency_list.txt or particle_positions.txt; y down as in images, numbers from 1
  graphml,     ///< NetworkX, Gephi: beads as nodes, contacts as edges; y up
  csv          ///< for tables; z down
};

/// Formats that keep beads and contacts apart write one of them; `dump local` keeps contacts with the floor apart, too.
enum class NetworkPart { contacts, beads, walls };

/// Whether the format has this part in a file of its own.
bool has_part(PileFormat format, NetworkPart part);

struct PileExport {
  PileFormat format = PileFormat::csv;
  NetworkPart part = NetworkPart::contacts;
  std::string origin;  ///< where the pile comes from, for formats that have room for a remark
};

/// What such a file cannot say of this pile, in a sentence; nothing if it says all.
std::string lost_in(const PileView& pile, const PileExport& what);

/// Is told how a file begins before there is one, and throws if it may not take the place of what is there.
using Accept = std::function<void(std::string_view begins)>;

/// Writes all of a pile, layer by layer; the file appears whole or not at all. Throws EnvironmentError as StreamedFile
/// does, InputError as PileLayers::hold(), Interrupted.
void export_pile(PileLayers& pile, const PileExport& what, const std::filesystem::path& file, const Accept& accept);

}  // namespace granuscope
