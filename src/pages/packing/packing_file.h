#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "packing/packing.h"

namespace granuscope {
/// Where the contacts of a packing stand, and what a file cannot say itself.
struct PackingFiles {
  std::filesystem::path contacts;
  std::filesystem::path particles;                 ///< empty: none, contacts say where they are
  std::vector<std::string> columns;                ///< names of the columns of `contacts`; empty: as its header says
  std::vector<std::string> particle_columns;       ///< the same of `particles`
  std::optional<double> step;                      ///< of a dump, or frame of a table; none: the last one
  std::array<std::optional<double>, 2> periods{};  ///< of the box in x and y; none: as a dump says, or no period
};

/// Names of columns that mean something, for help and messages.
std::string known_contact_columns();
std::string known_particle_columns();

/// Reads contacts from `dump local` of LAMMPS or LIGGGHTS, from a table with names of columns (commas, semicolons, tabs
/// or spaces; a line of units or comments begins with #), or from PeGS' adjacency list, which has none; particles from
/// `dump custom`, a table, or PeGS' positions. Throws InputError that names up to some lines and what each lacks.
Packing read_packing(const PackingFiles& files);

}  // namespace granuscope
