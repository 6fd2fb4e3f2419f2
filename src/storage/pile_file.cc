#include "storage/pile_file.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <utility>

#include "storage/hdf5_reader.h"
#include "storage/hdf5_writer.h"

namespace granuscope {
namespace {

constexpr const char* format_name = "granuscope pile";
constexpr std::uint64_t format_version = 1;
constexpr const char* units =
    "lengths in bead diameters, forces in units of the load on one ordinary top bead; V down, H right, pushed onto the "
    "lower bead";

using ForceArray = std::pair<const char*, std::vector<double> Pile::*>;
constexpr std::array<ForceArray, 4> force_arrays = {
    ForceArray{"/V_R", &Pile::V_R}, {"/V_L", &Pile::V_L}, {"/H_R", &Pile::H_R}, {"/H_L", &Pile::H_L}};

/// A file of another program may do without naming the format, as long as it holds what a pile holds.
void check_format(const Hdf5Reader& file) {
  if (file.has_attribute("/", "format") && file.text("/", "format") != format_name) {
    file.fail(fmt::format("it is a {} file. Name a pile file.", file.text("/", "format")));
  }
  if (file.has_attribute("/", "format_version") && file.count("/", "format_version") != format_version) {
    file.fail(fmt::format("it has version {} of the format where {} is known. Use the program that wrote it.",
                          file.count("/", "format_version"), format_version));
  }
}

/// Shape [layers, columns] of a lattice that can be.
LatticeSpec read_lattice(const Hdf5Reader& file) {
  const Shape shape = file.shape(force_arrays.front().first);
  constexpr auto most = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  if (shape.size() != 2 || shape[0] < 1 || shape[1] < 4 || shape[0] > most || shape[1] > most) {
    file.fail(
        fmt::format("its dataset '{}' has the shape {}, not [layers, columns] with at least 1 layer and 4 "
                    "columns. Make the file again or name another one.",
                    force_arrays.front().first, describe_shape(shape)));
  }
  return {.columns = static_cast<int>(shape[1]), .layers = static_cast<int>(shape[0])};
}

}  // namespace

void write_pile(const std::filesystem::path& file, const Pile& pile) {
  const auto layers = static_cast<std::uint64_t>(pile.lattice.layers());
  const auto columns = static_cast<std::uint64_t>(pile.lattice.columns());
  Hdf5Writer writer(file, (4 * layers + 1) * columns * sizeof(double));
  writer.attribute("/", "format", format_name);
  writer.attribute("/", "format_version", format_version);
  writer.attribute("/", "units", units);
  writer.attribute("/", "mu", pile.mu);
  writer.attribute("/", "law", pile.law);
  writer.attribute("/", "seed", pile.seed);
  writer.attribute("/", "sample", pile.sample);
  for (const auto& [path, forces] : force_arrays) writer.dataset(path, {layers, columns}, pile.*forces);
  writer.dataset("/load", {columns}, pile.load);
  writer.commit();
}

Pile read_pile(const std::filesystem::path& file) {
  const Hdf5Reader reader(file, "a pile file");
  check_format(reader);
  const LatticeSpec spec = read_lattice(reader);
  const auto layers = static_cast<std::uint64_t>(spec.layers);
  const auto columns = static_cast<std::uint64_t>(spec.columns);

  // Every array is read, and so its size found true, before the pile takes memory by its claimed size.
  std::array<std::vector<double>, force_arrays.size()> forces;
  for (std::size_t i = 0; i < forces.size(); ++i) forces[i] = reader.numbers(force_arrays[i].first, {layers, columns});
  std::vector<double> load = reader.numbers("/load", {columns});

  Pile pile{Lattice(spec)};
  for (std::size_t i = 0; i < forces.size(); ++i) pile.*(force_arrays[i].second) = std::move(forces[i]);
  pile.load = std::move(load);
  pile.mu = reader.number("/", "mu");
  pile.law = reader.text("/", "law");
  pile.seed = reader.count("/", "seed");
  pile.sample = reader.count("/", "sample");
  return pile;
}

}  // namespace granuscope
