#include "storage/ensemble_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "storage/configuration_json.h"
#include "storage/ensemble_format.h"
#include "storage/hdf5_reader.h"
#include "storage/hdf5_writer.h"
#include "storage/lattice_axes.h"
#include "support/digest.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

using namespace ensemble_format;

constexpr const char* units =
    "per block and layer: sums over samples; weights in units of the load on one ordinary top bead";

/// What the numbers of a quantity are, for whoever reads them without this program.
struct QuantityMeaning {
  std::string_view quantity;
  const char *unit, *unit_of_square;  ///< of the sums, and of the sums of squares
  const char* axis = "column";        ///< along which the numbers of a profile follow each other
};

constexpr const char *load_unit = "loads of one top bead", *squared_load = "squared loads of one top bead",
                     *pure = "dimensionless";
constexpr QuantityMeaning meanings[] = {
    {"weight", load_unit, squared_load},
    {"response", pure, pure},
    {"correlation", pure, pure, "mode"},
    {"correlation_H", pure, pure, "mode"},
    {"propagation", squared_load, "loads of one top bead to the power 4", "part of the correlation of a mode"},
    {"thrust", pure, pure},
    {"weight_variance", squared_load, "loads of one top bead to the power 4"},
    {"redrawn", pure, pure},
    {"redrawn_below_overload", pure, pure},
    {"least_force", load_unit, squared_load},
    {"redrawn_force", load_unit, squared_load},
    {"redrawn_together", "beads", "squared beads"},
    {"response_thrust", pure, pure},
    {"middle", pure, pure},
    {"traction", pure, pure}};

/// Null for a quantity that no estimator has.
const QuantityMeaning* meaning_of(std::string_view quantity) {
  const auto* const found = std::find_if(std::begin(meanings), std::end(meanings),
                                         [&](const QuantityMeaning& one) { return one.quantity == quantity; });
  return found == std::end(meanings) ? nullptr : found;
}

/// What a caller must keep to; a reader finds the same broken rules as InputError.
void check_name(const std::string& quantity) {
  static const std::set<std::string> taken = {"",  ".", counters_group, failed_group, "count", "layers", "block_keys",
                                              "x", "z"};
  if (taken.contains(quantity) || quantity.find('/') != std::string::npos) {
    throw std::logic_error(fmt::format("'{}' cannot name a quantity", quantity));
  }
}

void check_shape(const BlockSums& sums, const std::string& quantity, const QuantitySums& numbers) {
  const std::size_t values =
      sums.count.size() * sums.layers.size() * static_cast<std::size_t>(std::max(numbers.width, 0));
  if (numbers.width < 1 || numbers.sum.size() != values ||
      numbers.sum_of_squares.size() != (numbers.has_squares() ? values : 0)) {
    throw std::logic_error(fmt::format("quantity '{}' does not have the shape [blocks, layers, width]", quantity));
  }
}

void write_failed(Hdf5Writer& writer, const std::vector<FailedSample>& failed) {
  std::vector<std::uint64_t> samples;
  std::vector<int> layers;
  std::vector<std::string> replays;
  for (const FailedSample& one : failed) {
    samples.push_back(one.sample);
    layers.push_back(one.layer);
    replays.push_back(one.replay);
  }
  writer.group("/failed");
  writer.dataset("/failed/sample", {failed.size()}, samples);
  writer.dataset("/failed/layer", {failed.size()}, layers);
  writer.dataset("/failed/replay", replays);
  describe_dataset(writer, "/failed/sample", "number of the sample", "failure");
  describe_dataset(writer, "/failed/layer", "number of the layer, 0 at the top", "failure");
  describe_dataset(writer, "/failed/replay", "command that meets the failure again", "failure");
}

void describe_sums(Hdf5Writer& writer, const std::string& quantity, const QuantitySums& numbers) {
  const QuantityMeaning* const meaning = meaning_of(quantity);
  const std::string axes = fmt::format("block, layer, {}", numbers.width == 1 ? "one"
                                                           : meaning          ? meaning->axis
                                                                              : "column");
  for (const bool squared : {false, true}) {
    if (squared && !numbers.has_squares()) continue;
    const std::string path = fmt::format("/{}/{}", quantity, squared ? "sum_of_squares" : "sum");
    writer.attribute(path, "axes", axes);
    if (meaning != nullptr) writer.attribute(path, "units", squared ? meaning->unit_of_square : meaning->unit);
  }
}

/// All but the numbers, for which there is room.
void compose(Hdf5Writer& writer, const EnsembleRecord& header, const std::vector<std::string>& keys) {
  const BlockSums& sums = header.sums;
  const std::uint64_t blocks = sums.count.size(), layers = sums.layers.size();
  for (const auto& [quantity, numbers] : sums.quantities) check_name(quantity);
  writer.attribute("/", "format", name);
  writer.attribute("/", "format_version", version);
  writer.attribute("/", "units", units);
  writer.attribute("/", "configuration", header.configuration);
  writer.attribute("/", "configuration_json", configuration_json(header.configuration));
  writer.attribute("/", "configuration_key", header.configuration_key);
  writer.attribute("/", "sampling_version", header.sampling_version);
  writer.attribute("/", "first_block", static_cast<std::uint64_t>(sums.first_block));
  writer.dataset("/count", {blocks}, sums.count);
  writer.dataset("/layers", {layers}, sums.layers);
  writer.dataset("/block_keys", keys);
  describe_dataset(writer, "/count", "samples", "block");
  describe_dataset(writer, "/block_keys", "digest of the block", "block");
  if (sums.quantities.contains("propagation")) {
    describe_dataset(writer, "/layers", "layers from base to partner, beside the reference lag", "layer");
  } else {
    describe_dataset(writer, "/layers", "number of the layer, 0 at the top", "layer");
    int columns = 0;
    for (const auto& [quantity, numbers] : sums.quantities) columns = std::max(columns, numbers.width);
    write_lattice_axes(writer, columns, sums.layers, sums.rows);
  }
  if (sums.rows != RowGeometry{}) {  // those of the beads go without saying
    writer.attribute("/", row_spacing, exact(sums.rows.spacing));
    writer.attribute("/", rows_staggered, sums.rows.staggered ? "yes" : "no");
  }
  for (const auto& [quantity, numbers] : sums.quantities) {
    const Shape shape = {blocks, layers, static_cast<std::uint64_t>(numbers.width)};
    writer.group("/" + quantity);
    for (const char* sum : {"sum", "sum_of_squares"}) {
      if (sum != std::string_view("sum") && !numbers.has_squares()) continue;
      const std::string path = fmt::format("/{}/{}", quantity, sum);
      writer.reserve(path, shape);
    }
    describe_sums(writer, quantity, numbers);
  }
  writer.group("/counters");
  for (const auto& [counter, field] : sampler_counters) writer.attribute("/counters", counter, header.counts.*field);
  write_failed(writer, header.failed);
}

void put_block(Hdf5Writer& writer, std::size_t at, const BlockSums& one) {
  for (const auto& [quantity, numbers] : one.quantities) {
    check_shape(one, quantity, numbers);
    writer.put("/" + quantity + "/sum", at * numbers.sum.size(), numbers.sum);
    if (numbers.has_squares())
      writer.put("/" + quantity + "/sum_of_squares", at * numbers.sum.size(), numbers.sum_of_squares);
  }
}

/// Before anything is known of the blocks: what is said of them later takes the same room.
void compose_places(Hdf5Writer& writer, EnsembleRecord header) {
  header.failed.clear();
  compose(writer, header, std::vector<std::string>(header.sums.count.size(), cache_key("")));
}

}  // namespace

void write_ensemble(const std::filesystem::path& file, const EnsembleRecord& header,
                    const std::vector<std::string>& keys, const std::function<BlockSums(std::size_t)>& block) {
  Hdf5Writer writer(file);
  compose(writer, header, keys);
  writer.begin_data();
  for (std::size_t at = 0; at < header.sums.count.size(); ++at) put_block(writer, at, block(at));
  writer.commit();
}

SharedEnsemble::SharedEnsemble(const std::filesystem::path& file, EnsembleRecord header) : writer_(file) {
  compose_places(writer_, std::move(header));
  writer_.begin_shared_data(file);
}

void SharedEnsemble::put(std::size_t at, const BlockSums& block) {
  put_block(writer_, at, block);
  writer_.sync();
}

bool finish_shared(const std::filesystem::path& file, const std::filesystem::path& target, const EnsembleRecord& header,
                   const std::vector<std::string>& keys) {
  std::map<std::string, std::uint64_t> places;
  {
    Hdf5Writer before(target);
    compose_places(before, header);
    places = before.places();
  }
  Hdf5Writer whole(target);
  compose(whole, header, keys);
  if (whole.places() != places) return false;
  whole.begin_shared_data(file);
  whole.commit();
  return true;
}

void write_ensemble(const std::filesystem::path& file, const EnsembleRecord& record) {
  for (const auto& [quantity, numbers] : record.sums.quantities) {
    check_name(quantity);
    check_shape(record.sums, quantity, numbers);
  }
  std::vector<std::string> keys;
  for (std::size_t at = 0; at < record.sums.count.size(); ++at) keys.push_back(key_of_block(record.sums, at));
  write_ensemble(file, record, keys, [&](std::size_t at) { return take_blocks(record.sums, at, 1); });
}

}  // namespace granuscope
