#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
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
/// less what beads weigh by themselves), "response" (w with the overload minus w without, per unit of it),
/// "correlation" (of the loads with the weights, as a spectrum; "correlation_H" with H), "propagation" (correlations of
/// layers, see ensemble/fluctuation_estimator.h), "thrust" (sqrt(3) sum(H_R - H_L) / sum(w) of a layer),
/// "weight_variance" (mean over columns of (w/<w> - 1)^2), "redrawn" and "redrawn_below_overload" (shares of a layer's
/// beads), "response_thrust" (see ensemble/paired_estimator.h). Which ones an ensemble holds depends on its estimator.
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

}  // namespace granuscope
