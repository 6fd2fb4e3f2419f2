#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace granuscope {
/// A particle of somebody's packing. Lengths in the units of its file, y up.
struct Particle {
  std::int64_t id = 0;
  double x = 0, y = 0;
  double radius = 0;  ///< 0: the file does not say
};

/// A contact of two particles, or of one with a wall. Forces in the units of the file.
struct PackingContact {
  static constexpr std::size_t wall = static_cast<std::size_t>(-1);

  std::size_t first = wall, second = wall;  ///< places in Packing::particles
  bool placed = false;                      ///< the file says where it is; the next four are numbers then
  double x = 0, y = 0;                      ///< centre of the first particle
  double branch_x = 0, branch_y = 0;        ///< from there to the centre of the second one, or of its nearest image
  double N = 0;                             ///< compression > 0
  double T = 0;  ///< > 0 turns the force on the second particle from the branch to the left; of some files |T|
};

/// Contacts of any two-dimensional packing, as other programs write them.
struct Packing {
  std::vector<Particle> particles;
  std::vector<PackingContact> contacts;
  bool tangential = false;        ///< the file has tangential forces
  std::size_t twins = 0;          ///< lines left out, since they tell a contact again from its other side
  std::optional<double> step;     ///< of the dump, or frame of the table, that was read
  std::size_t steps = 1;          ///< that the file has
  bool sized = false;             ///< mean_diameter is known
  double mean_diameter = 1;       ///< of the particles; of files without radii the median length of a branch
  double force_unit = 0;          ///< of pictures; 0: the mean normal force
  std::vector<std::string> told;  ///< sentences on what was taken for what
};

}  // namespace granuscope
