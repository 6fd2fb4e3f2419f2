#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "packing/number_table.h"
#include "packing/packing.h"

namespace granuscope {
/// Where the contacts of a packing stand, and what a file cannot say itself.
struct PackingFiles {
  std::filesystem::path contacts;
  std::filesystem::path particles;                 ///< empty: none, contacts say where they are
  std::filesystem::path walls;                     ///< contacts with walls, where they stand apart; empty: none
  std::vector<std::string> columns;                ///< names of the columns of `contacts`, or NAME=COLUMN for some;
                                                   ///< empty: as its header says
  std::vector<std::string> particle_columns;       ///< the same of `particles`
  std::vector<std::string> wall_columns;           ///< and of `walls`
  std::array<std::optional<double>, 2> periods{};  ///< of the box in x and y; none: as a dump says, or no period
};

/// Names of columns that mean something, for help and messages.
std::string known_contact_columns();
std::string known_particle_columns();

/// Contacts from `dump local` of LAMMPS or LIGGGHTS, from a table with names of columns (commas, semicolons, tabs or
/// spaces; a line of units or comments begins with #), from PeGS' adjacency list, which has none, or from VTK (vtu,
/// vtp, vtk: its lines of two points, whose ends are particles unless arrays of cells name them); particles from `dump
/// custom`, a table, PeGS' positions, or points of VTK, those of the contacts' file where they have a radius. A contact
/// with a wall has a negative id2, or no id2 and a point of contact (`compute wall/gran/local` of LIGGGHTS, `fix
/// wall/gran` of LAMMPS with `contacts`). Files are read once. All functions throw InputError that names up to some
/// lines and what each lacks.
class PackingSource {
 public:
  explicit PackingSource(PackingFiles files);
  /// Of a dump, or frames of a table; empty where there is but one.
  std::vector<double> steps() const;
  /// `step`: none for the last one. Particles and walls are those of the step that the contacts have; a table of them
  /// without frames is of all steps, and one of walls may lack a frame.
  Packing read(std::optional<double> step) const;

 private:
  PackingFiles files_;
  NumberFile contacts_;
  std::optional<NumberFile> particles_, walls_;
};

}  // namespace granuscope
