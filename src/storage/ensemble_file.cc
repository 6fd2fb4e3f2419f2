#include "storage/ensemble_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <utility>

#include "storage/byte_record.h"
#include "storage/hdf5_reader.h"
#include "storage/hdf5_writer.h"
#include "storage/isolated_read.h"
#include "support/digest.h"

namespace granuscope {
namespace {

constexpr const char* kind = "an ensemble file";
constexpr const char* format_name = "granuscope ensemble";
constexpr std::uint64_t format_version = 3;
constexpr const char* units =
    "per block and layer: sums over samples; weights in units of the load on one ordinary top bead";

/// Groups that are not quantities.
constexpr const char* counters_group = "counters";
constexpr const char* failed_group = "failed";

/// What a caller must keep to; a reader finds the same broken rules as InputError.
void check_record(const EnsembleRecord& record) {
  const BlockSums& sums = record.sums;
  for (const auto& [name, quantity] : sums.quantities) {
    const std::size_t values = sums.count.size() * sums.layers.size() * static_cast<std::size_t>(quantity.width);
    if (quantity.width < 1 || quantity.sum.size() != values || quantity.sum_of_squares.size() != values) {
      throw std::logic_error(fmt::format("quantity '{}' does not have the shape [blocks, layers, width]", name));
    }
    if (name.empty() || name == "." || name == counters_group || name == failed_group || name == "count" ||
        name == "layers" || name.find('/') != std::string::npos) {
      throw std::logic_error(fmt::format("'{}' cannot name a quantity", name));
    }
  }
}

/// A key of all numbers of the sums, so that a reader notices a flipped bit: HDF5 guards its metadata only.
std::string key_of(const BlockSums& sums) {
  std::string bytes;
  const auto append = [&bytes](const auto& numbers) {
    bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(numbers[0]));
  };
  append(sums.count);
  append(sums.layers);
  for (const auto& [name, quantity] : sums.quantities) {
    bytes += name;
    append(quantity.sum);
    append(quantity.sum_of_squares);
  }
  return cache_key(bytes);
}

std::size_t data_bytes(const EnsembleRecord& record) {
  std::size_t bytes = 0;
  for (const auto& [name, quantity] : record.sums.quantities) bytes += 2 * quantity.sum.size() * sizeof(double);
  return bytes + record.sums.count.size() * sizeof(std::uint64_t) + record.failed.size() * 128;
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
}

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

QuantitySums read_quantity(const Hdf5Reader& reader, const std::string& name, std::uint64_t blocks,
                           std::uint64_t layers) {
  const std::string sum = "/" + name + "/sum";
  const Shape shape = reader.shape(sum);
  if (shape.size() != 3 || shape[0] != blocks || shape[1] != layers || shape[2] < 1 ||
      shape[2] > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
    reader.fail(fmt::format("its dataset '{}' has the shape {}, not [{}, {}, width]. Make the file again.", sum,
                            describe_shape(shape), blocks, layers));
  }
  QuantitySums result;
  result.width = static_cast<int>(shape[2]);
  result.sum = reader.numbers(sum, shape);
  result.sum_of_squares = reader.numbers("/" + name + "/sum_of_squares", shape);
  return result;
}

void check_format(const Hdf5Reader& reader) {
  if (!reader.has_attribute("/", "format")) {
    reader.fail("it does not say that it is an ensemble, so another program wrote it. Name an ensemble file.");
  }
  if (const std::string format = reader.text("/", "format"); format != format_name) {
    reader.fail(fmt::format("it is a {} file. Name an ensemble file.", format));
  }
  if (const std::uint64_t version = reader.count("/", "format_version"); version != format_version) {
    reader.fail(fmt::format("it has version {} of the format where {} is known. Use the program that wrote it.",
                            version, format_version));
  }
}

BlockSums read_sums(const Hdf5Reader& reader) {
  const std::uint64_t blocks = length_of(reader, "/count");
  const std::uint64_t layers = length_of(reader, "/layers");
  BlockSums sums;
  sums.count = reader.counts("/count", {blocks});
  sums.layers = reader.integers("/layers", {layers});
  const auto not_ascending = [](int upper, int lower) { return upper >= lower; };
  if ((!sums.layers.empty() && sums.layers.front() < 0) ||
      std::adjacent_find(sums.layers.begin(), sums.layers.end(), not_ascending) != sums.layers.end()) {
    reader.fail("its list of layers is not ascending from 0 on. Make the file again.");
  }
  for (const std::string& name : reader.groups()) {
    if (name == counters_group || name == failed_group) continue;
    sums.quantities.emplace(name, read_quantity(reader, name, blocks, layers));
  }
  return sums;
}

EnsembleRecord read_record(const std::filesystem::path& file) {
  const Hdf5Reader reader(file, kind);
  check_format(reader);
  EnsembleRecord record;
  record.configuration = reader.text("/", "configuration");
  record.configuration_key = reader.text("/", "configuration_key");
  record.sampling_version = reader.text("/", "sampling_version");
  record.sums = read_sums(reader);
  if (reader.text("/", "sums_key") != key_of(record.sums)) {
    reader.fail("its numbers are not those it was written with: the file is damaged. Make the file again.");
  }
  for (const auto& [name, counter] : sampler_counters) record.counts.*counter = reader.count("/counters", name);
  record.failed = read_failed(reader);
  return record;
}

// From the process that reads the file to the one that asked for it.

std::string to_bytes(const EnsembleRecord& record) {
  ByteWriter bytes;
  for (const auto* text : {&record.configuration, &record.configuration_key, &record.sampling_version})
    bytes.put(*text);
  bytes.put(record.sums.layers);
  bytes.put(record.sums.count);
  bytes.put(record.sums.quantities.size());
  for (const auto& [name, quantity] : record.sums.quantities) {
    bytes.put(name);
    bytes.put(quantity.width);
    bytes.put(quantity.sum);
    bytes.put(quantity.sum_of_squares);
  }
  bytes.put(record.counts);
  bytes.put(record.failed.size());
  for (const FailedSample& one : record.failed) {
    bytes.put(one.sample);
    bytes.put(one.layer);
    bytes.put(one.replay);
  }
  return bytes.take();
}

EnsembleRecord from_bytes(const std::string& text) {
  EnsembleRecord record;
  ByteReader bytes(text);
  for (auto* field : {&record.configuration, &record.configuration_key, &record.sampling_version}) bytes.get(*field);
  bytes.get(record.sums.layers);
  bytes.get(record.sums.count);
  std::size_t length = 0;
  bytes.get(length);
  for (std::size_t i = 0; i < length; ++i) {
    std::string name;
    bytes.get(name);
    QuantitySums& quantity = record.sums.quantities[name];
    bytes.get(quantity.width);
    bytes.get(quantity.sum);
    bytes.get(quantity.sum_of_squares);
  }
  bytes.get(record.counts);
  bytes.get(length);
  for (std::size_t i = 0; i < length; ++i) {
    FailedSample& one = record.failed.emplace_back();
    bytes.get(one.sample);
    bytes.get(one.layer);
    bytes.get(one.replay);
  }
  return record;
}

}  // namespace

void write_ensemble(const std::filesystem::path& file, const EnsembleRecord& record) {
  check_record(record);
  Hdf5Writer writer(file, data_bytes(record));
  writer.attribute("/", "format", format_name);
  writer.attribute("/", "format_version", format_version);
  writer.attribute("/", "units", units);
  writer.attribute("/", "configuration", record.configuration);
  writer.attribute("/", "configuration_key", record.configuration_key);
  writer.attribute("/", "sampling_version", record.sampling_version);
  writer.attribute("/", "sums_key", key_of(record.sums));

  const BlockSums& sums = record.sums;
  const std::uint64_t blocks = sums.count.size();
  const std::uint64_t layers = sums.layers.size();
  writer.dataset("/count", {blocks}, sums.count);
  writer.dataset("/layers", {layers}, sums.layers);
  for (const auto& [name, quantity] : sums.quantities) {
    const Shape shape = {blocks, layers, static_cast<std::uint64_t>(quantity.width)};
    writer.group("/" + name);
    writer.dataset("/" + name + "/sum", shape, quantity.sum);
    writer.dataset("/" + name + "/sum_of_squares", shape, quantity.sum_of_squares);
  }

  writer.group("/counters");
  for (const auto& [name, counter] : sampler_counters) writer.attribute("/counters", name, record.counts.*counter);
  write_failed(writer, record.failed);
  writer.commit();
}

EnsembleRecord read_ensemble(const std::filesystem::path& file) {
  return from_bytes(read_in_child(file, kind, [&] { return to_bytes(read_record(file)); }));
}

std::string read_ensemble_configuration(const std::filesystem::path& file) {
  return read_in_child(file, kind, [&] {
    const Hdf5Reader reader(file, kind);
    check_format(reader);
    return reader.text("/", "configuration");
  });
}

}  // namespace granuscope
