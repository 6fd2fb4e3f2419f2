#include "sampling/row_noise.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/row_noise.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

#include "sampling/philox-inl.h"

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Beads 2k and 2k + 1 share counter k of their row.
void FillRowNumbers(const PhiloxKeys& keys, const std::uint64_t* HWY_RESTRICT samples, std::uint32_t row,
                    std::uint32_t last_word, std::size_t columns, double* HWY_RESTRICT numbers) {
  const hn::CappedTag<std::uint64_t, group_lanes> d;
  const hn::RebindToFloat<decltype(d)> number;
  const auto rows = hn::Set(d, std::uint64_t{row}), words = hn::Set(d, std::uint64_t{last_word});
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    const auto sample = hn::LoadU(d, samples + k);
    for (std::size_t bead = 0; bead < columns; bead += 2) {
      const auto u = philox_uniforms(d, keys, hn::Set(d, std::uint64_t{bead / 2}), rows, sample, words);
      hn::StoreU(u.first, number, numbers + bead * group_lanes + k);
      if (bead + 1 < columns) hn::StoreU(u.second, number, numbers + (bead + 1) * group_lanes + k);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <Random123/philox.h>

#include <algorithm>

namespace granuscope {

HWY_EXPORT(FillRowNumbers);

double noise_number(std::uint64_t seed, std::uint64_t sample, int row, int bead, std::uint32_t number,
                    NoiseStream stream) {
  const r123::Philox4x32::ctr_type counter{{static_cast<std::uint32_t>(bead / 2), static_cast<std::uint32_t>(row),
                                            static_cast<std::uint32_t>(sample),
                                            number << 8 | static_cast<std::uint32_t>(stream)}};
  const r123::Philox4x32::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  const auto words = r123::Philox4x32()(counter, key);
  return bead % 2 == 0 ? to_unit_interval(words[0], words[1]) : to_unit_interval(words[2], words[3]);
}

RowNoise::RowNoise(int columns, NoiseCells cells)
    : columns_(columns),
      cells_(cells),
      numbers_(aligned_array<double>(static_cast<std::size_t>(columns) * group_lanes)) {
  if (!cells.single()) of_cells_ = aligned_array<double>(static_cast<std::size_t>(columns) * group_lanes);
}

void RowNoise::begin(std::uint64_t seed, const LaneSamples& samples) {
  seed_ = seed;
  samples_ = samples;
  band_.fill(-1);
  for (std::size_t k = 0; k < group_lanes; ++k) {
    first_row_[k] = static_cast<int>(noise_number(seed, samples[k], 0, 0, 0, NoiseStream::offset) * cells_.rows);
  }
}

const double* RowNoise::row(int row, std::uint32_t number) {
  const PhiloxKeys keys(seed_);
  if (cells_.single()) {
    HWY_DYNAMIC_DISPATCH(FillRowNumbers)
    (keys, samples_.data(), static_cast<std::uint32_t>(row), number << 8 | static_cast<std::uint32_t>(NoiseStream::row),
     static_cast<std::size_t>(columns_), numbers_.get());
    return numbers_.get();
  }
  for (std::size_t k = 0; k < group_lanes; ++k) {
    const int band = (row + first_row_[k]) / cells_.rows;
    if (band == band_[k]) continue;
    band_[k] = band;
    const int first =
        static_cast<int>(noise_number(seed_, samples_[k], band, 1, 0, NoiseStream::offset) * cells_.columns);
    for (int cell = 0; cell < columns_ / cells_.columns; ++cell) {
      of_cells_[static_cast<std::size_t>(cell)] = noise_number(seed_, samples_[k], band, cell, 0, NoiseStream::cell);
    }
    for (int i = 0; i < columns_; ++i) {
      const int cell = (i + first) % columns_ / cells_.columns;
      numbers_[static_cast<std::size_t>(i) * group_lanes + k] = of_cells_[static_cast<std::size_t>(cell)];
    }
  }
  return numbers_.get();
}

std::uint64_t RowNoise::drawn(int rows) const {
  const auto of_row = static_cast<std::uint64_t>(columns_ / cells_.columns);
  return of_row * static_cast<std::uint64_t>((rows + cells_.rows - 1) / cells_.rows);
}

}  // namespace granuscope
#endif
