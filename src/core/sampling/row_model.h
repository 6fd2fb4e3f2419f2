#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "sampling/model_spec.h"
#include "sampling/pile_group.h"
#include "sampling/sampler.h"

namespace granuscope {
/// Up to eight piles that are drawn side by side: one to a lane; lanes without a pile repeat the last one.
using LaneSamples = std::array<std::uint64_t, group_lanes>;

/// What a row of beads hands down, summed over its beads for each pile.
struct RowSums {
  std::array<double, group_lanes> thrust{};                 ///< horizontal momentum flux, sum of sigma_xx
  std::array<std::array<double, group_lanes>, 2> extras{};  ///< of extra_names(model)
};

/// A model that hands the forces of a row down to the next one and never looks back, on eight piles side by side. What
/// it makes of a pile depends on (seed, sample, load) only. Rows have the shape [columns, group_lanes].
class RowModel {
 public:
  virtual ~RowModel() = default;

  /// Begins with row 0 under these loads, of the shape of a row.
  virtual void begin(std::uint64_t seed, const LaneSamples& samples, const double* loads) = 0;
  /// The weight that enters each bead of the present row.
  virtual const double* weight() const = 0;
  /// The horizontal force that enters it; none in a scalar model. Its unit is of no importance: see the estimator
  /// fluctuation.
  virtual const double* horizontal() { return nullptr; }
  /// Goes on to the next row. `sums`, if not null, gets those of what the present one, number `row`, hands down.
  virtual void hand_down(int row, RowSums* sums) = 0;
  /// Uniform numbers that a pile of this many rows takes.
  virtual std::uint64_t uniforms(int rows) const = 0;
};

std::unique_ptr<RowModel> make_row_model(const ModelSpec& model, int columns);

/// Draws piles of any RowModel, eight side by side. No such pile fails. Its groups hold weights and moments, no forces
/// of contacts.
class RowModelSampler final : public Sampler {
 public:
  RowModelSampler(const SamplerSpec& spec, const Lattice& lattice);

  /// Throws InputError: a Pile holds contacts of beads, which these models have none of.
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;
  std::span<const PileGroup> draw_groups(std::span<const std::uint64_t> samples,
                                         std::span<const std::span<const double>> loads,
                                         std::span<std::optional<SamplingFailure>> failures) override;
  void keep_layers(const KeptLayers& kept) override;

  /// Of eight piles that keep these layers, or all of them, in bytes.
  static double memory(const Lattice& lattice, const KeptLayers* kept = nullptr);

 private:
  /// What a group's piles are measured by.
  struct Kept {
    AlignedArray<double> weights, horizontal;
    std::vector<LayerMoments> moments;
    std::vector<double> extras;
    std::array<IdentityResiduals, group_lanes> residuals{};
  };
  Kept& room(std::size_t group);
  void draw_group(const LaneSamples& samples, std::span<const std::span<const double>> loads, Kept& kept);
  void keep_row(int layer, const RowSums& sums, const std::array<double, group_lanes>& total, Kept& kept) const;

  SamplerSpec spec_;
  std::unique_ptr<RowModel> model_;
  std::vector<int> layers_;  ///< kept, ascending
  std::vector<int> place_;   ///< of each layer among them, -1: none
  bool horizontal_ = false;
  AlignedArray<double> load_;
  std::deque<Kept> kept_;  ///< of the groups of the last call
};

/// Cells of so many columns and rows within which noise is the same. Where the first one begins is random in every
/// pile, and in every band of cells anew, so that the noise is the same everywhere.
struct NoiseCells {
  int columns = 1, rows = 1;
  bool single() const { return columns == 1 && rows == 1; }
};

/// Uniform numbers in [0, 1) for the beads of rows, of the shape [columns, group_lanes]. Each depends on (seed, sample,
/// row, bead, number) only, or on the cell instead of row and bead.
class RowNoise {
 public:
  RowNoise(int columns, NoiseCells cells);
  void begin(std::uint64_t seed, const LaneSamples& samples);
  /// Those of a row, the rows being asked for one after the other; they hold until the next call. `number` tells
  /// several of the same bead apart (cells: 0 only).
  const double* row(int row, std::uint32_t number = 0);
  /// How many are drawn for so many rows, one to a bead.
  std::uint64_t drawn(int rows) const;

 private:
  int columns_;
  NoiseCells cells_;
  std::uint64_t seed_ = 0;
  LaneSamples samples_{};
  std::array<int, group_lanes> first_row_{};  ///< how many rows of the first band lie above the pile
  std::array<int, group_lanes> band_{};       ///< of which the numbers are in numbers_
  AlignedArray<double> numbers_, of_cells_;
};

/// The low byte of Philox's last counter word, beside the streams of random_key.cc.
enum class NoiseStream : std::uint32_t {
  row = 5,     ///< of single cells, by row, bead and number
  cell = 6,    ///< of others, by band and cell
  offset = 7,  ///< where cells begin: row 0, bead 0 in depth; row band, bead 1 along each band
};

/// The number that RowNoise uses, by itself and without vectors.
double noise_number(std::uint64_t seed, std::uint64_t sample, int row, int bead, std::uint32_t number,
                    NoiseStream stream);

}  // namespace granuscope
