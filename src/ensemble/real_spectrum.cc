#include "ensemble/real_spectrum.h"

#include <gsl/gsl_fft_halfcomplex.h>
#include <gsl/gsl_fft_real.h>

#include <new>
#include <stdexcept>

namespace granuscope {
namespace {

template <typename T>
T* checked(T* table) {
  if (table == nullptr) throw std::bad_alloc();
  return table;
}

template <typename T, void (*free)(T*)>
struct Free {
  void operator()(T* table) const { free(table); }
};

}  // namespace

struct RealSpectrum::Tables {
  explicit Tables(std::size_t n)
      : size(n),
        forward(checked(gsl_fft_real_wavetable_alloc(n))),
        backward(checked(gsl_fft_halfcomplex_wavetable_alloc(n))),
        work(checked(gsl_fft_real_workspace_alloc(n))) {}
  std::size_t size;
  std::unique_ptr<gsl_fft_real_wavetable, Free<gsl_fft_real_wavetable, gsl_fft_real_wavetable_free>> forward;
  std::unique_ptr<gsl_fft_halfcomplex_wavetable,
                  Free<gsl_fft_halfcomplex_wavetable, gsl_fft_halfcomplex_wavetable_free>>
      backward;
  std::unique_ptr<gsl_fft_real_workspace, Free<gsl_fft_real_workspace, gsl_fft_real_workspace_free>> work;
};

RealSpectrum::RealSpectrum(std::size_t size) : tables_(std::make_unique<Tables>(size)) {}
RealSpectrum::~RealSpectrum() = default;
RealSpectrum::RealSpectrum(RealSpectrum&&) noexcept = default;

void RealSpectrum::transform(std::span<double> ring) const {
  if (ring.size() != tables_->size) throw std::logic_error("a Fourier transform was handed a ring of another size");
  gsl_fft_real_transform(ring.data(), 1, ring.size(), tables_->forward.get(), tables_->work.get());
}

void RealSpectrum::inverse(std::span<double> spectrum) const {
  if (spectrum.size() != tables_->size) throw std::logic_error("a Fourier transform was handed a ring of another size");
  gsl_fft_halfcomplex_inverse(spectrum.data(), 1, spectrum.size(), tables_->backward.get(), tables_->work.get());
}

}  // namespace granuscope
