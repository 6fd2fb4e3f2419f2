#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "sampling/pile_group.h"

namespace granuscope {

/// One stage of a transform: rings of `length` beads, `stride` of them interleaved, are split into `factor` times as
/// many.
struct FourierStage {
  std::size_t factor, length, stride, size;
  const double *cosine, *sine;  ///< of 2 pi k / size
  const double *from_re, *from_im;
  double *to_re, *to_im;
};

/// Discrete Fourier transforms of eight rings side by side, sum_j z_j exp(-2 pi i m j / n), one ring to a vector lane,
/// for any size n (fast where its prime factors are small). Stockham's algorithm; a ring's numbers are the same bytes
/// in every lane and on every machine. FFTW chooses its arithmetic by the machine, so that bytes would depend on it;
/// GSL does one ring at a time and takes four times as long.
class GroupFourier {
 public:
  explicit GroupFourier(std::size_t size);

  /// In place; arrays [size, 8], aligned for vectors. Neither thread-safe nor const: there is room to work in.
  void transform(double* re, double* im);
  std::size_t size() const { return size_; }

 private:
  std::size_t size_;
  std::vector<std::size_t> factors_;
  AlignedArray<double> cosine_, sine_;  ///< of 2 pi k / size
  AlignedArray<double> work_re_, work_im_;
};

/// From the transform of a + i b of a ring of `size` numbers, modes 1, 2, ... of both, each times its phase `cosine` +
/// i `sine`: `fields` [4, 8] of a mode are the real and imaginary part of a, then of b; those of the next mode lie
/// `stride` numbers farther.
struct PhaseFactor {
  double cosine = 1, sine = 0;
};
void separate_fields(const double* re, const double* im, std::size_t size, std::span<const PhaseFactor> phases,
                     std::size_t stride, double* fields);

/// The parts of 2 x 2 cross-correlations of two fields that are even under x -> -x: the real parts of w w' and H H',
/// the imaginary parts of w H' and H w'.
inline constexpr std::size_t correlation_parts = 4;

/// Adds up one Fourier mode's correlations between layers of eight piles. `fields` [layers, 4, 8]: real and imaginary
/// part of w, then of H. For every pair of a base and its partner, indices of layers, `sums` [4, 8] gains the parts of
/// X_partner X_base^*, in their order. `pairs` holds base and partner in turn.
void add_correlations(const double* fields, const std::vector<int>& pairs, double* sums);

}  // namespace granuscope
