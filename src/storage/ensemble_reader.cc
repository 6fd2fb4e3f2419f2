#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <span>
#include <utility>

#include "storage/byte_record.h"
#include "storage/ensemble_file.h"
#include "storage/ensemble_format.h"
#include "storage/hdf5_reader.h"
#include "storage/isolated_read.h"
#include "support/error.h"

namespace granuscope {
namespace {

using namespace ensemble_format;

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
};

int read_first_block(const Hdf5Reader& reader) {
  const std::uint64_t first = reader.count("/", "first_block");
  if (first > most_blocks) reader.fail(fmt::format("it begins with block {}. Make the file again.", first));
  return static_cast<int>(first);
}

RowGeometry read_rows(const Hdf5Reader& reader) {
  RowGeometry rows;
  if (!reader.has_attribute("/", row_spacing)) return rows;
  const std::string spacing = reader.text("/", row_spacing);
  rows.staggered = reader.text("/", rows_staggered) == "yes";
  const auto [end, error] = std::from_chars(spacing.data(), spacing.data() + spacing.size(), rows.spacing);
  if (error != std::errc{} || end != spacing.data() + spacing.size() || !(rows.spacing > 0)) {
    reader.fail(fmt::format("its rows are '{}' apart, which is no distance. Make the file again.", spacing));
  }
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
  return found;
}

template <class Bytes, class Raw>
void each_field(Bytes& put_or_get, Raw& raw) {
  put_or_get(raw.dataset, raw.shape, raw.offset, raw.values);
}

std::string to_bytes(const Description& found) {
  ByteWriter writer;
  const auto put = [&writer](const auto&... field) { (writer.put(field), ...); };
  const EnsembleRecord& header = found.header;
  put(header.configuration, header.configuration_key, header.sampling_version, header.sums.layers, header.sums.rows,
      header.sums.count, header.sums.first_block, header.counts, header.sums.quantities.size());
  for (const auto& [quantity, described] : header.sums.quantities) {
    put(quantity, described.width);
    each_field(put, found.stored.at(quantity).first);
    each_field(put, found.stored.at(quantity).second);
  }
  for (const std::string& key : found.keys) put(key);
  put(header.failed.size());
  for (const FailedSample& one : header.failed) put(one.sample, one.layer, one.replay);
  return writer.take();
}

Description from_bytes(const std::string& bytes) {
  ByteReader reader(bytes);
  const auto get = [&reader](auto&... field) { (reader.get(field), ...); };
  Description found;
  EnsembleRecord& header = found.header;
  std::size_t length = 0;
  get(header.configuration, header.configuration_key, header.sampling_version, header.sums.layers, header.sums.rows,
      header.sums.count, header.sums.first_block, header.counts, length);
  for (std::size_t i = 0; i < length; ++i) {
    std::string quantity;
    get(quantity);
    get(header.sums.quantities[quantity].width);
    each_field(get, found.stored[quantity].first);
    each_field(get, found.stored[quantity].second);
  }
  found.keys.resize(header.sums.count.size());
  for (std::string& key : found.keys) get(key);
  get(length);
  header.failed.resize(length);
  for (FailedSample& one : header.failed) get(one.sample, one.layer, one.replay);
  return found;
}

}  // namespace

EnsembleReader::EnsembleReader(const std::filesystem::path& file) : file_(file) {
  Description found = from_bytes(read_in_child(file, kind, [&] { return to_bytes(describe(file)); }));
  header_ = std::move(found.header);
  keys_ = std::move(found.keys);
  for (auto& [quantity, stored] : found.stored) {
    stored_[quantity] = {std::move(stored.first), std::move(stored.second)};
  }
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
        fmt::format("cannot read '{}' as {}: the numbers of its block {} are not those it was written with: the file "
                    "is damaged. Make the file again.",
                    file_.string(), kind, sums.first_block));
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

}  // namespace granuscope
