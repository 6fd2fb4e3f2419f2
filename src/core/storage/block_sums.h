#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <ranges>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "model/lattice.h"

namespace granuscope {
/// Sums of one measured quantity over the samples of each block, shape [blocks, layers, width], row-major; width is
/// the number of columns for a profile and 1 for a number per layer. Only the latter have squares: they tell how far
/// the samples depend on each other, and of profiles nobody asks that.
struct QuantitySums {
  int width = 1;
  std::vector<double> sum;             ///< empty for a profile that is elsewhere (BlockSums::elsewhere)
  std::vector<double> sum_of_squares;  ///< empty for a profile

  bool has_squares() const { return width == 1; }
  static auto fields(auto& one) { return std::tie(one.width, one.sum, one.sum_of_squares); }
};

/// Profiles that are somewhere else than in memory, and may be far larger than it.
class ProfileSource {
 public:
  ProfileSource() = default;
  ProfileSource(const ProfileSource&) = delete;
  ProfileSource& operator=(const ProfileSource&) = delete;
  virtual ~ProfileSource() = default;

  /// The sums of one block of a quantity at the recorded layer number `row`, [width]. Any number of threads may ask.
  virtual void read(const std::string& quantity, std::size_t block, std::size_t row, std::span<double> to) const = 0;
};

/// The sums of all blocks of a quantity at one layer. What it is taken from must outlive it.
class LayerSums {
 public:
  /// In memory: those of block b begin at first[b * stride].
  LayerSums(const double* first, std::size_t blocks, std::size_t stride, std::size_t width)
      : first_(first), blocks_(blocks), stride_(stride), width_(width) {}
  /// Or read: [blocks, width].
  LayerSums(std::vector<double> read, std::size_t width)
      : read_(std::move(read)), first_(read_.data()), blocks_(read_.size() / width), stride_(width), width_(width) {}
  LayerSums(LayerSums&&) = default;
  LayerSums& operator=(LayerSums&&) = default;
  LayerSums(const LayerSums&) = delete;
  LayerSums& operator=(const LayerSums&) = delete;
  ~LayerSums() = default;

  std::size_t blocks() const { return blocks_; }
  std::size_t width() const { return width_; }
  const double* block(std::size_t b) const { return first_ + b * stride_; }

 private:
  std::vector<double> read_;
  const double* first_;
  std::size_t blocks_, stride_, width_;
};

/// Sums of an ensemble, by block. Merging two ensembles is adding. Quantities: "weight" (w = V_R + V_L of each bead,
/// less what beads weigh by themselves), "moved_weight" (the same, moved to the overloaded bead and less what its group
/// shares, see ensemble/estimator.h), "response" (w with the overload minus w without, per unit of it),
/// "correlation" (of the loads with the weights, as a spectrum; "correlation_H" with H), "propagation" (correlations of
/// layers, see ensemble/estimator.h), "thrust" (sqrt(3) sum(H_R - H_L) / sum(w) of a layer),
/// "weight_variance" (mean over columns of (w/<w> - 1)^2), "redrawn" and "redrawn_below_overload" (shares of a layer's
/// beads), "response_thrust" (see ensemble/estimator.h), flat_tests (sampling/polytope.h). Which ones an ensemble holds
/// depends on its estimator.
struct BlockSums {
  std::vector<int> layers;           ///< which layers are recorded, ascending
  std::vector<std::uint64_t> count;  ///< samples that entered each block
  std::map<std::string, QuantitySums> quantities;
  RowGeometry rows;     ///< where the layers lie
  int first_block = 0;  ///< number of the first of these blocks in the ensemble, of which they may be a part
  std::shared_ptr<const ProfileSource> elsewhere = {};  ///< not null: it has the profiles, which are not in memory
  double scatter = 1;  ///< factor by which `layer` moves the means of the blocks apart, see stopped_scatter

  /// The sums of a quantity at recorded layer number `row`, wherever they are.
  LayerSums layer(const std::string& quantity, std::size_t row) const;
  int blocks() const { return static_cast<int>(count.size()); }
  std::uint64_t samples() const { return std::accumulate(count.begin(), count.end(), std::uint64_t{0}); }
  /// Without what is elsewhere.
  static auto fields(auto& all) { return std::tie(all.layers, all.rows, all.count, all.first_block, all.quantities); }
};

/// The same with all numbers in memory.
BlockSums in_memory(const BlockSums& sums);

/// Zeros for so many blocks of the quantities of `like`, and its layers.
BlockSums zero_sums(const BlockSums& like, int first_block, std::size_t blocks);

/// Blocks at places first .. first + blocks - 1 of `all`, as they are.
BlockSums take_blocks(const BlockSums& all, std::size_t first, std::size_t blocks);

/// A key of all numbers of the block at place `at`, of its number, its layers and the names of its quantities: equal
/// keys, equal blocks.
std::string key_of_block(const BlockSums& sums, std::size_t at);

/// Whether the values of a list stand in memory as they go through bytes.
template <class List>
concept PlainValues =
    std::ranges::contiguous_range<List> && std::is_trivially_copyable_v<std::ranges::range_value_t<List>>;

/// Values one after the other as bytes, for a process on the same machine: texts, lists, maps, pairs, structs that name
/// their members (fields), and what can be copied as it stands. Read them back in the same order.
class ByteWriter {
 public:
  template <class Value>
  void put(const Value& value) {
    if constexpr (requires { Value::fields(value); }) {
      std::apply([this](const auto&... field) { (this->put(field), ...); }, Value::fields(value));
    } else if constexpr (requires { value.size(); }) {
      put(std::uint64_t{value.size()});
      if constexpr (PlainValues<Value>) {
        bytes_.append(reinterpret_cast<const char*>(value.data()), value.size() * sizeof(typename Value::value_type));
      } else {
        for (const auto& one : value) put(one);
      }
    } else if constexpr (requires { value.second; }) {
      put(value.first);
      put(value.second);
    } else {
      static_assert(std::is_trivially_copyable_v<Value>);
      bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// The other end. Throws std::logic_error where the bytes end too early: then the two ends do not fit.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : left_(bytes) {}

  template <class Value>
  void get(Value& value) {
    if constexpr (requires { Value::fields(value); }) {
      std::apply([this](auto&... field) { (this->get(field), ...); }, Value::fields(value));
    } else if constexpr (requires { typename Value::mapped_type; }) {
      for (std::uint64_t left = get<std::uint64_t>(); left > 0; --left) {
        const auto key = get<typename Value::key_type>();
        get(value[key]);
      }
    } else if constexpr (requires { value.resize(0); }) {
      const auto count = get<std::uint64_t>();
      if constexpr (PlainValues<Value>) {
        if (count > left_.size() / sizeof(typename Value::value_type)) next(left_.size() + 1);
        value.resize(count);
        const std::string_view bytes = next(count * sizeof(typename Value::value_type));
        if (count > 0) std::memcpy(value.data(), bytes.data(), bytes.size());
      } else {
        value.clear();
        for (std::uint64_t left = count; left > 0; --left) get(value.emplace_back());
      }
    } else if constexpr (requires { value.second; }) {
      get(value.first);
      get(value.second);
    } else {
      static_assert(std::is_trivially_copyable_v<Value>);
      std::memcpy(&value, next(sizeof value).data(), sizeof value);
    }
  }
  template <class Value>
  Value get() {
    Value value{};
    get(value);
    return value;
  }

 private:
  std::string_view next(std::size_t count) {
    if (count > left_.size()) throw std::logic_error("a byte record ends too early");
    const std::string_view found = left_.substr(0, count);
    left_.remove_prefix(count);
    return found;
  }

  std::string_view left_;
};

template <class Value>
std::string to_bytes(const Value& value) {
  ByteWriter writer;
  writer.put(value);
  return writer.take();
}

template <class Value>
Value from_bytes(std::string_view bytes) {
  return ByteReader(bytes).get<Value>();
}

}  // namespace granuscope
