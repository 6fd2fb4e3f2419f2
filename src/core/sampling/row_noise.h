#pragma once
#include <cstdint>

#include "sampling/row_model.h"

namespace granuscope {

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
