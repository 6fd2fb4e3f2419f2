#pragma once
#include <cstddef>
#include <memory>
#include <span>

namespace granuscope {

/// The discrete Fourier transform of real rings of one size, sum_j f_j exp(-2 pi i m j / n), by GSL's mixed-radix FFT.
/// Spectra have n entries: Re of m = 0, then Re and Im of m = 1, 2, ..., and for even n Re of m = n/2.
class RealSpectrum {
 public:
  explicit RealSpectrum(std::size_t size);
  ~RealSpectrum();
  RealSpectrum(RealSpectrum&&) noexcept;

  /// Both in place; inverse(transform(f)) is f. `ring` has the size given.
  void transform(std::span<double> ring) const;
  void inverse(std::span<double> spectrum) const;

 private:
  struct Tables;
  std::unique_ptr<Tables> tables_;
};

}  // namespace granuscope
