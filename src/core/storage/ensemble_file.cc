#include "storage/ensemble_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include "storage/pile_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

/// What an ensemble file is called and holds, for those who write and read it.
namespace granuscope::ensemble_format {

inline constexpr const char* kind = "an ensemble file";
inline constexpr const char* name = "granuscope ensemble";
inline constexpr std::uint64_t version = 4;
/// More blocks than any ensemble has.
inline constexpr std::uint64_t most_blocks = 1'000'000;

/// Where the rows lie, if not as those of beads: a number in full, and "yes" or "no".
inline constexpr const char *row_spacing = "row_spacing", *row_pitch = "row_pitch", *rows_staggered = "rows_staggered";

/// The digest of all that is in no block. Files of before have none.
inline constexpr const char* record_key = "record_key";

/// Groups that are not quantities.
inline constexpr const char* counters_group = "counters";
inline constexpr const char* failed_group = "failed";

}  // namespace granuscope::ensemble_format

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
constexpr const char* bin_axis = "bin, see ensemble/force_counts.h";  ///< no place in x
constexpr QuantityMeaning meanings[] = {
    {"weight", load_unit, squared_load},
    {"moved_weight", load_unit, squared_load, "distance from the overloaded bead, which is the middle one"},
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
    {"failing_again", pure, pure},
    {"response_thrust", pure, pure},
    {"position", pure, pure},
    {"position_squared", pure, pure},
    {"thrust_drift", load_unit, squared_load},
    {"weight_drift", squared_load, "loads of one top bead to the power 4"},
    {"wave_drift", squared_load, "loads of one top bead to the power 4"},
    {"middle", pure, pure},
    {"traction", pure, pure},
    {"force_counts", "beads, then contacts", "", bin_axis},
    {"force_moments", "powers of the mean weight", "", bin_axis}};

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

/// What results depend on beside the numbers, and where these lie, as one digest; the blocks by their own.
std::string key_of_record(const EnsembleRecord& header, const std::vector<std::string>& keys,
                          const std::vector<double>& places) {
  ByteWriter writer;
  writer.put(header.configuration);
  writer.put(header.sampling_version);
  writer.put(header.sums.rows.spacing);
  writer.put(header.sums.rows.staggered);
  if (header.sums.rows.pitch != 1) writer.put(header.sums.rows.pitch);
  writer.put(header.counts);
  for (const std::string& key : keys) writer.put(key);
  for (const FailedSample& one : header.failed) writer.put(one);
  writer.put(places);
  return cache_key(writer.take());
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
  std::vector<double> places;
  if (sums.quantities.contains("propagation")) {
    describe_dataset(writer, "/layers", "layers from base to partner, beside the reference lag", "layer");
  } else {
    describe_dataset(writer, "/layers", "number of the layer, 0 at the top", "layer");
    int columns = 0;
    for (const auto& [quantity, numbers] : sums.quantities) {
      const QuantityMeaning* const meaning = meaning_of(quantity);
      if (meaning == nullptr || meaning->axis != bin_axis) columns = std::max(columns, numbers.width);
    }
    places = write_lattice_axes(writer, columns, sums.layers, sums.rows);
  }
  writer.attribute("/", record_key, key_of_record(header, keys, places));
  if (sums.rows != RowGeometry{}) {  // those of the beads go without saying
    writer.attribute("/", row_spacing, exact(sums.rows.spacing));
    writer.attribute("/", rows_staggered, sums.rows.staggered ? "yes" : "no");
    if (sums.rows.pitch != 1) writer.attribute("/", row_pitch, exact(sums.rows.pitch));
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

namespace {

std::uint64_t length_of(const Hdf5Reader& reader, const std::string& dataset) {
  const Shape shape = reader.shape(dataset);
  if (shape.size() != 1) {
    reader.fail(fmt::format("its dataset '{}' has the shape {}, not that of a list. Make the file again.", dataset,
                            describe_shape(shape)));
  }
  return shape[0];
}

std::vector<FailedSample> read_failed(const Hdf5Reader& reader) {
  const std::uint64_t length = length_of(reader, "/failed/sample");
  const std::vector<std::uint64_t> samples = reader.counts("/failed/sample", {length});
  const std::vector<int> layers = reader.integers("/failed/layer", {length});
  std::vector<std::string> replays = reader.texts("/failed/replay", {length});
  std::vector<FailedSample> failed;
  for (std::size_t i = 0; i < samples.size(); ++i) failed.push_back({samples[i], layers[i], std::move(replays[i])});
  return failed;
}

void check_format(const Hdf5Reader& reader) {
  if (!reader.has_attribute("/", "format")) {
    reader.fail("it does not say that it is an ensemble, so another program wrote it. Name an ensemble file.");
  }
  if (const std::string format = reader.text("/", "format"); format != name) {
    reader.fail(fmt::format("it is a {} file. Name an ensemble file.", format));
  }
  if (const std::uint64_t found = reader.count("/", "format_version"); found != version) {
    reader.fail(fmt::format("it has version {} of the format where {} is known. Use the program that wrote it.", found,
                            version));
  }
}

/// What the library is needed for, in the form in which it leaves the process that runs it.
struct Description {
  EnsembleRecord header;
  std::vector<std::string> keys;
  std::map<std::string, std::pair<RawData, RawData>> stored;  ///< sums and squares

  static auto fields(auto& one) {
    auto& header = one.header;
    return std::tie(header.configuration, header.configuration_key, header.sampling_version, header.sums, header.counts,
                    header.failed, one.keys, one.stored);
  }
};

int read_first_block(const Hdf5Reader& reader) {
  const std::uint64_t first = reader.count("/", "first_block");
  if (first > most_blocks) reader.fail(fmt::format("it begins with block {}. Make the file again.", first));
  return static_cast<int>(first);
}

RowGeometry read_rows(const Hdf5Reader& reader) {
  RowGeometry rows;
  if (!reader.has_attribute("/", row_spacing)) return rows;
  rows.staggered = reader.text("/", rows_staggered) == "yes";
  const auto read = [&](const char* name, double& distance) {
    const std::string text = reader.text("/", name);
    if (!read_whole(text, distance) || !(distance > 0)) {
      reader.fail(fmt::format("its rows are '{}' apart, which is no distance. Make the file again.", text));
    }
  };
  read(row_spacing, rows.spacing);
  if (reader.has_attribute("/", row_pitch)) read(row_pitch, rows.pitch);
  return rows;
}

Description describe(const std::filesystem::path& file) {
  const Hdf5Reader reader(file, kind);
  check_format(reader);
  Description found;
  EnsembleRecord& header = found.header;
  header.configuration = reader.text("/", "configuration");
  header.configuration_key = reader.text("/", "configuration_key");
  header.sampling_version = reader.text("/", "sampling_version");
  const std::uint64_t blocks = length_of(reader, "/count"), layers = length_of(reader, "/layers");
  BlockSums& sums = header.sums;
  sums.first_block = read_first_block(reader);
  sums.count = reader.counts("/count", {blocks});
  sums.layers = reader.integers("/layers", {layers});
  sums.rows = read_rows(reader);
  const auto not_ascending = [](int upper, int lower) { return upper >= lower; };
  if ((!sums.layers.empty() && sums.layers.front() < 0) ||
      std::adjacent_find(sums.layers.begin(), sums.layers.end(), not_ascending) != sums.layers.end()) {
    reader.fail("its list of layers is not ascending from 0 on. Make the file again.");
  }
  for (const std::string& quantity : reader.groups()) {
    if (quantity == counters_group || quantity == failed_group) continue;
    const std::string sum = "/" + quantity + "/sum";
    const Shape shape = reader.shape(sum);
    if (shape.size() != 3 || shape[0] != blocks || shape[1] != layers || shape[2] < 1 ||
        shape[2] > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
      reader.fail(fmt::format("its dataset '{}' has the shape {}, not [{}, {}, width]. Make the file again.", sum,
                              describe_shape(shape), blocks, layers));
    }
    QuantitySums& described = sums.quantities[quantity];
    described.width = static_cast<int>(shape[2]);
    auto& [of_sum, of_squares] = found.stored[quantity];
    of_sum = reader.raw_data(sum, shape);
    if (described.has_squares()) of_squares = reader.raw_data("/" + quantity + "/sum_of_squares", shape);
  }
  found.keys = reader.texts("/block_keys", {blocks});
  for (const auto& [counter, field] : sampler_counters) header.counts.*field = reader.count("/counters", counter);
  header.failed = read_failed(reader);
  if (!reader.has_attribute("/", record_key)) return found;
  std::vector<double> places;
  if (!sums.quantities.contains("propagation")) {
    for (const char* axis : {"/x", "/z"}) {
      if (!reader.has_dataset(axis)) continue;
      const std::vector<double> along = reader.numbers(axis, reader.shape(axis));
      places.insert(places.end(), along.begin(), along.end());
    }
  }
  if (reader.text("/", record_key) != key_of_record(header, found.keys, places)) {
    reader.fail(
        "what it says beside its numbers (configuration, counters, failed piles, places) is not what it was written "
        "with: the file is damaged. Make the file again.");
  }
  return found;
}

}  // namespace

EnsembleReader::EnsembleReader(const std::filesystem::path& file) : file_(file) {
  auto found = from_bytes<Description>(read_in_child(file, kind, [&] { return to_bytes(describe(file)); }));
  header_ = std::move(found.header);
  keys_ = std::move(found.keys);
  for (auto& [quantity, stored] : found.stored) stored_[quantity] = {std::move(stored.first), std::move(stored.second)};
}

BlockSums EnsembleReader::read_block(std::size_t at) const { return read_block(at, RawDataFile(file_, kind)); }

BlockSums EnsembleReader::read_block(std::size_t at, const RawDataFile& numbers) const {
  BlockSums sums = zero_sums(header_.sums, header_.sums.first_block + static_cast<int>(at), 1);
  sums.count[0] = header_.sums.count.at(at);
  for (auto& [quantity, values] : sums.quantities) {
    const Stored& stored = stored_.at(quantity);
    numbers.read(stored.sum, at * values.sum.size(), values.sum);
    if (values.has_squares()) numbers.read(stored.sum_of_squares, at * values.sum.size(), values.sum_of_squares);
  }
  if (key_of_block(sums, 0) != keys_.at(at)) {
    throw InputError(
        "cannot read '{}' as {}: the numbers of its block {} are not those it was written with: the file is damaged. "
        "Make the file again.",
        file_.string(), kind, sums.first_block);
  }
  return sums;
}

/// The profiles of a file, which stays open.
class EnsembleReader::Profiles : public ProfileSource {
 public:
  explicit Profiles(const std::filesystem::path& file) : numbers_(file, kind), reader_(file) {}

  void read(const std::string& quantity, std::size_t block, std::size_t row, std::span<double> to) const override {
    numbers_.read(reader_.stored_.at(quantity).sum, (block * reader_.header_.sums.layers.size() + row) * to.size(), to);
  }
  BlockSums read_block(std::size_t at) const { return reader_.read_block(at, numbers_); }
  const EnsembleRecord& header() const { return reader_.header(); }

 private:
  RawDataFile numbers_;
  EnsembleReader reader_;
};

EnsembleRecord open_ensemble(const std::filesystem::path& file) {
  auto profiles = std::make_shared<const EnsembleReader::Profiles>(file);
  EnsembleRecord record = profiles->header();
  BlockSums& sums = record.sums;
  for (auto& [quantity, values] : sums.quantities) {
    const std::size_t numbers = values.has_squares() ? sums.count.size() * sums.layers.size() : 0;
    values.sum.reserve(numbers);
    values.sum_of_squares.reserve(numbers);
  }
  for (std::size_t at = 0; at < sums.count.size(); ++at) {
    const BlockSums one = profiles->read_block(at);
    for (auto& [quantity, values] : sums.quantities) {
      if (!values.has_squares()) continue;
      const QuantitySums& more = one.quantities.at(quantity);
      values.sum.insert(values.sum.end(), more.sum.begin(), more.sum.end());
      values.sum_of_squares.insert(values.sum_of_squares.end(), more.sum_of_squares.begin(), more.sum_of_squares.end());
    }
  }
  sums.elsewhere = std::move(profiles);
  return record;
}

EnsembleRecord read_ensemble(const std::filesystem::path& file) {
  EnsembleRecord record = open_ensemble(file);
  record.sums = in_memory(record.sums);
  return record;
}

std::string read_ensemble_configuration(const std::filesystem::path& file) {
  return read_in_child(file, kind, [&] {
    const Hdf5Reader reader(file, kind);
    check_format(reader);
    return reader.text("/", "configuration");
  });
}

namespace {

/// JSON wants a digit first, or a minus and a digit, and knows neither inf nor nan nor leading zeros.
bool is_json_number(std::string_view text) {
  const std::string_view digits = text.starts_with('-') ? text.substr(1) : text;
  if (digits.empty() || digits.front() < '0' || digits.front() > '9') return false;
  if (digits.size() > 1 && digits.front() == '0' && digits[1] >= '0' && digits[1] <= '9') return false;
  double value = 0;
  return read_whole(text, value) && std::isfinite(value) && text.back() != '.';
}

std::string json_string(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

std::string configuration_json(std::string_view lines) {
  std::string json;
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(line.size() < lines.size() ? line.size() + 1 : line.size());
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view value = line.substr(equals + 1);
    const bool plain = value == "true" || value == "false" || is_json_number(value);
    json += fmt::format("{}{}: {}", json.empty() ? "" : ", ", json_string(line.substr(0, equals)),
                        plain ? std::string(value) : json_string(value));
  }
  return "{" + json + "}";
}

}  // namespace granuscope
