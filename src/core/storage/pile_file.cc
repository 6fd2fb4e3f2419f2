#include "storage/pile_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "storage/block_sums.h"
#include "storage/ensemble_file.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr const char* kind = "a pile file";
constexpr const char* format_name = "granuscope pile";
constexpr std::uint64_t format_version = 1;
constexpr const char* pile_units =
    "lengths in bead diameters, forces in units of the load on one ordinary top bead; V down, H right, pushed onto the "
    "lower bead";

struct ForceArray {
  const char* path;
  bool horizontal;
  std::vector<double> Pile::*in_pile;
  std::vector<double> PilePart::*in_part;
};
constexpr std::array<ForceArray, 4> force_arrays = {{{"/V_R", false, &Pile::V_R, &PilePart::V_R},
                                                     {"/V_L", false, &Pile::V_L, &PilePart::V_L},
                                                     {"/H_R", true, &Pile::H_R, &PilePart::H_R},
                                                     {"/H_L", true, &Pile::H_L, &PilePart::H_L}}};

/// A file of another program may do without naming the format, as long as it holds what a pile holds.
void check_pile_format(const Hdf5Reader& file) {
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
  const Shape shape = file.shape(force_arrays.front().path);
  constexpr auto most = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  if (shape.size() != 2 || shape[0] < 1 || shape[1] < 4 || shape[0] > most || shape[1] > most) {
    file.fail(
        fmt::format("its dataset '{}' has the shape {}, not [layers, columns] with at least 1 layer and 4 "
                    "columns. Make the file again or name another one.",
                    force_arrays.front().path, describe_shape(shape)));
  }
  return {.columns = static_cast<int>(shape[1]), .layers = static_cast<int>(shape[0])};
}

/// What a file says of its pile, and where the forces stand.
struct PileDescription {
  LatticeSpec lattice;
  double mu = 0;
  std::string law;
  LoadLine load_line;
  double bead_weight = 0;
  std::uint64_t seed = 0, sample = 0;
  std::vector<RawData> forces;  ///< of force_arrays
  RawData load;

  static auto fields(auto& one) {
    return std::tie(one.lattice, one.load_line, one.bead_weight, one.mu, one.law, one.seed, one.sample, one.forces,
                    one.load);
  }
};

PileDescription describe_pile(const std::filesystem::path& file) {
  const Hdf5Reader reader(file, kind);
  check_pile_format(reader);
  PileDescription found;
  found.lattice = read_lattice(reader);
  const auto layers = static_cast<std::uint64_t>(found.lattice.layers);
  const auto columns = static_cast<std::uint64_t>(found.lattice.columns);
  for (const ForceArray& array : force_arrays) found.forces.push_back(reader.raw_data(array.path, {layers, columns}));
  found.load = reader.raw_data("/load", {columns});
  if (reader.has_attribute("/load", "slope")) {
    found.load_line = {reader.number("/load", "slope"), reader.number("/load", "offset"),
                       reader.has_attribute("/load", "excess_alone")};
  }
  if (reader.has_attribute("/", "contact_angle")) {
    found.lattice.angle = reader.number("/", "contact_angle");
    if (const Problem wrong = find_problem(found.lattice)) reader.fail(wrong->message + ". Make the file again.");
  }
  if (reader.has_attribute("/", "bead_weight")) found.bead_weight = reader.number("/", "bead_weight");
  found.mu = reader.number("/", "mu");
  try {
    const FrictionCone cone(found.mu, BeadGeometry(found.lattice.angle));
  } catch (const InputError& error) {
    reader.fail(fmt::format("{}. Make the file again.", error.what()));
  }
  found.law = reader.text("/", "law");
  found.seed = reader.count("/", "seed");
  found.sample = reader.count("/", "sample");
  return found;
}

/// A pile file that has been found to hold what it claims, by a process of its own: whatever the library makes of a
/// damaged file happens there.
class StoredPile {
 public:
  explicit StoredPile(const std::filesystem::path& file)
      : found_(from_bytes<PileDescription>(read_in_child(file, kind, [&] { return to_bytes(describe_pile(file)); }))),
        numbers_(file, kind) {}

  PilePart without_forces() const {
    PilePart part{Lattice(found_.lattice)};
    part.load.resize(static_cast<std::size_t>(part.lattice.columns()));
    numbers_.read(found_.load, 0, part.load);
    part.load_line = found_.load_line;
    part.bead_weight = found_.bead_weight;
    part.mu = found_.mu;
    part.law = found_.law;
    part.seed = found_.seed;
    part.sample = found_.sample;
    return part;
  }

  /// Replaces the forces of `part` by those of another range.
  void read(const PileRange& range, PilePart& part) const {
    part.range = range;
    // Where a layer's beads go on past the seam of the ring, they stand in two places; whole layers stand in one piece.
    const auto beads = static_cast<std::size_t>(range.beads);
    const auto to_seam = static_cast<std::size_t>(part.lattice.columns() - range.first_bead);
    for (std::size_t i = 0; i < force_arrays.size(); ++i) {
      if (force_arrays[i].horizontal && !range.horizontal) continue;
      std::vector<double>& forces = part.*(force_arrays[i].in_part);
      // Every array has been found to be as large as it claims before memory is taken by its size.
      forces.resize(range.size());
      if (range.beads == part.lattice.columns() && range.first_bead == 0) {
        numbers_.read(found_.forces[i], part.lattice.index(range.first_layer, 0), forces);
        continue;
      }
      for (int layer = 0; layer < range.layers; ++layer) {
        const std::size_t in_file = part.lattice.index(range.first_layer + layer, 0);
        const std::span row = std::span(forces).subspan(static_cast<std::size_t>(layer) * beads, beads);
        const std::size_t before_seam = std::min(beads, to_seam);
        numbers_.read(found_.forces[i], in_file + static_cast<std::size_t>(range.first_bead), row.first(before_seam));
        if (before_seam < beads) numbers_.read(found_.forces[i], in_file, row.subspan(before_seam));
      }
    }
  }

 private:
  PileDescription found_;
  RawDataFile numbers_;
};

class StoredLayers : public PileLayers {
 public:
  StoredLayers(const std::filesystem::path& file, const std::function<PileRange(const Lattice&)>& choose,
               std::size_t bytes)
      : stored_(file), part_(stored_.without_forces()) {
    part_.range = choose(part_.lattice);
    about_ = view_of(part_);
    held_ = about_;
    held_.range.layers = 0;
    const std::size_t arrays = about_.range.horizontal ? 4 : 2;
    const std::size_t layer_bytes = arrays * sizeof(double) * static_cast<std::size_t>(about_.range.beads);
    const auto in_bytes = static_cast<int>(std::min<std::size_t>(bytes / layer_bytes, 1 << 30));
    band_layers_ = std::max(band_layers, in_bytes);
  }

  const PileView& about() const override { return about_; }

  const PileView& hold(int first, int last) override {
    const auto has = [this](int layer) {
      return layer >= held_.range.first_layer && layer < held_.range.first_layer + held_.range.layers;
    };
    if (has(first) && has(last)) return held_;
    const PileRange& all = about_.range;
    PileRange band = all;
    if (all.layers > band_layers_) {
      band.first_layer = first;
      band.layers = std::min(std::max(last - first + 1, band_layers_), all.first_layer + all.layers - first);
    }
    held_.range.layers = 0;  // in case reading fails half way
    const auto start = std::chrono::steady_clock::now();
    stored_.read(band, part_);
    seconds_reading_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    held_ = view_of(part_);
    return held_;
  }

  double seconds_reading() const override { return seconds_reading_; }

 private:
  StoredPile stored_;
  PilePart part_;
  PileView about_ = view_of(part_), held_ = about_;
  int band_layers_ = 0;
  double seconds_reading_ = 0;
};

}  // namespace

void write_pile(const std::filesystem::path& file, const Pile& pile) {
  const auto layers = static_cast<std::uint64_t>(pile.lattice.layers());
  const auto columns = static_cast<std::uint64_t>(pile.lattice.columns());
  const double angle = pile.lattice.geometry().angle;
  const bool tilted = angle != usual_angle;
  Hdf5Writer writer(file);
  writer.attribute("/", "format", format_name);
  writer.attribute("/", "format_version", format_version);
  writer.attribute("/", "units", pile_units);
  writer.attribute("/", "mu", pile.mu);
  writer.attribute("/", "law", pile.law);
  writer.attribute("/", "seed", pile.seed);
  writer.attribute("/", "sample", pile.sample);
  writer.attribute(
      "/", "configuration_json",
      configuration_json(fmt::format("law={}\nmu={}\nseed={}\nsample={}\ncolumns={}\nlayers={}\n{}", pile.law,
                                     exact(pile.mu), pile.seed, pile.sample, pile.lattice.columns(),
                                     pile.lattice.layers(), tilted ? fmt::format("angle={}\n", exact(angle)) : "")));
  if (tilted) writer.attribute("/", "contact_angle", angle);
  constexpr const char* force_unit = "loads of one top bead";
  for (const ForceArray& array : force_arrays) {
    writer.dataset(array.path, {layers, columns}, pile.*(array.in_pile));
    describe_dataset(writer, array.path, force_unit, "layer, column");
  }
  writer.dataset("/load", {columns}, pile.load);
  describe_dataset(writer, "/load", force_unit, "column");
  // The vertical parts stand there; files of upright loads are as they were before there were others.
  if (pile.load_line != LoadLine{}) {
    writer.attribute("/load", "slope", pile.load_line.slope);
    writer.attribute("/load", "offset", pile.load_line.offset);
    if (pile.load_line.of_excess) writer.attribute("/load", "excess_alone", "what is beyond 1");
  }
  if (pile.bead_weight != 0) writer.attribute("/", "bead_weight", pile.bead_weight);
  std::vector<int> all_layers(layers);
  std::iota(all_layers.begin(), all_layers.end(), 0);
  write_lattice_axes(writer, pile.lattice.columns(), all_layers,
                     {.spacing = pile.lattice.spacing(), .pitch = pile.lattice.pitch()});
  writer.commit();
}

PilePart read_pile_part(const std::filesystem::path& file, const std::function<PileRange(const Lattice&)>& choose) {
  const StoredPile stored(file);
  PilePart part = stored.without_forces();
  stored.read(choose(part.lattice), part);
  return part;
}

std::unique_ptr<PileLayers> open_pile_layers(const std::filesystem::path& file,
                                             const std::function<PileRange(const Lattice&)>& choose,
                                             std::size_t bytes) {
  return std::make_unique<StoredLayers>(file, choose, bytes);
}

Pile read_pile(const std::filesystem::path& file) {
  PilePart all = read_pile_part(file, whole_range);
  Pile pile(all.lattice);
  for (const ForceArray& array : force_arrays) pile.*(array.in_pile) = std::move(all.*(array.in_part));
  pile.load = std::move(all.load);
  pile.load_line = all.load_line;
  pile.bead_weight = all.bead_weight;
  pile.mu = all.mu;
  pile.law = std::move(all.law);
  pile.seed = all.seed;
  pile.sample = all.sample;
  return pile;
}

void describe_dataset(Hdf5Writer& writer, const std::string& path, std::string_view units, std::string_view axes) {
  writer.attribute(path, "units", units);
  writer.attribute(path, "axes", axes);
}

std::vector<double> write_lattice_axes(Hdf5Writer& writer, int columns, std::span<const int> layers,
                                       const RowGeometry& rows) {
  std::vector<double> z, x;
  for (const int layer : layers) z.push_back(rows.depth(layer));
  writer.dataset("/z", {z.size()}, z);
  describe_dataset(writer, "/z", "bead diameters", "layer");
  if (columns < fewest_columns) return z;  // nothing by columns is stored
  const Lattice lattice({.columns = columns, .layers = 2});
  for (const int parity : {0, 1}) {
    for (int bead = 0; bead < columns; ++bead) x.push_back(rows.pitch * lattice.x(rows.shifted(parity) ? 1 : 0, bead));
  }
  writer.dataset("/x", {2, static_cast<std::uint64_t>(columns)}, x);
  describe_dataset(writer, "/x", "bead diameters", "layer modulo 2, column");
  writer.attribute("/x", "overloaded_column", static_cast<std::uint64_t>(lattice.middle()));
  x.insert(x.end(), z.begin(), z.end());
  return x;
}

}  // namespace granuscope
