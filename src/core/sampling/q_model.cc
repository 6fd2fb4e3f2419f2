#include "sampling/row_model.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/q_model.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// q = disorder q' + (1 - disorder)/2; the lower-left neighbour of each bead gets left = q w, the lower-right one what
/// remains, and a bead of the next row what its upper left hands to the right and its upper right to the left. `shift`:
/// 0 where the next row lies half a bead further right, else 1.
void HandDownShares(const double* HWY_RESTRICT weight, const double* HWY_RESTRICT q, double disorder,
                    std::size_t columns, std::size_t shift, double* HWY_RESTRICT next) {
  const hn::CappedTag<double, group_lanes> d;
  const auto scale = hn::Set(d, disorder), equal = hn::Set(d, (1 - disorder) / 2);
  const auto left_of = [&](std::size_t at, auto w) {
    return hn::Mul(hn::Add(hn::Mul(scale, hn::LoadU(d, q + at)), equal), w);
  };
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    const std::size_t last = (columns - 1) * group_lanes + k;
    const auto w_last = hn::LoadU(d, weight + last);
    auto right = hn::Sub(w_last, left_of(last, w_last));
    // Bead i meets the right part of bead i - 1 in bead i - 1 + shift below.
    for (std::size_t i = 0; i < columns; ++i) {
      const auto w = hn::LoadU(d, weight + i * group_lanes + k);
      const auto left = left_of(i * group_lanes + k, w);
      const std::size_t below = shift == 1 ? i : (i == 0 ? columns - 1 : i - 1);
      hn::StoreU(hn::Add(right, left), d, next + below * group_lanes + k);
      right = hn::Sub(w, left);
    }
  }
}

/// 0 or 1 with equal chances.
void MakeCritical(double* HWY_RESTRICT q, std::size_t size) {
  const hn::CappedTag<double, group_lanes> d;
  const auto half = hn::Set(d, 0.5), one = hn::Set(d, 1.0);
  for (std::size_t i = 0; i < size; i += hn::Lanes(d)) {
    hn::StoreU(hn::IfThenElseZero(hn::Ge(hn::LoadU(d, q + i), half), one), d, q + i);
  }
}

/// The median of three uniform numbers has the density 6 q (1 - q).
void TakeMedian(const double* HWY_RESTRICT a, const double* HWY_RESTRICT b, double* HWY_RESTRICT q, std::size_t size) {
  const hn::CappedTag<double, group_lanes> d;
  for (std::size_t i = 0; i < size; i += hn::Lanes(d)) {
    const auto x = hn::LoadU(d, a + i), y = hn::LoadU(d, b + i), z = hn::LoadU(d, q + i);
    hn::StoreU(hn::Max(hn::Min(x, y), hn::Min(hn::Max(x, y), z)), d, q + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <utility>

#include "sampling/row_noise.h"

namespace granuscope {

HWY_EXPORT(HandDownShares);
HWY_EXPORT(MakeCritical);
HWY_EXPORT(TakeMedian);

namespace {

class QModel final : public RowModel {
 public:
  QModel(const QModelSpec& spec, int columns)
      : split_(spec.split),
        disorder_(spec.disorder),
        columns_(static_cast<std::size_t>(columns)),
        noise_(columns, {}),
        weight_(aligned_array<double>(size())),
        next_(aligned_array<double>(size())),
        q_(aligned_array<double>(3 * size())) {}

  void begin(std::uint64_t seed, const LaneSamples& samples, const double* loads) override {
    noise_.begin(seed, samples);
    std::copy_n(loads, size(), weight_.get());
  }
  const double* weight() const override { return weight_.get(); }

  void hand_down(int row, RowSums*) override {
    const double* q = noise_.row(row);
    if (split_ != SplitLaw::uniform) {
      std::copy_n(q, size(), q_.get());
      q = q_.get();
    }
    if (split_ == SplitLaw::critical) HWY_DYNAMIC_DISPATCH(MakeCritical)(q_.get(), size());
    if (split_ == SplitLaw::beta) {
      double *const second = q_.get() + size(), *const third = second + size();
      std::copy_n(noise_.row(row, 1), size(), second);
      std::copy_n(noise_.row(row, 2), size(), third);
      HWY_DYNAMIC_DISPATCH(TakeMedian)(second, third, q_.get(), size());
    }
    // The next row lies half a bead further right than an even one.
    HWY_DYNAMIC_DISPATCH(HandDownShares)
    (weight_.get(), q, disorder_, columns_, static_cast<std::size_t>(row % 2), next_.get());
    std::swap(weight_, next_);
  }

  std::uint64_t uniforms(int rows) const override { return noise_.drawn(rows) * (split_ == SplitLaw::beta ? 3 : 1); }

 private:
  std::size_t size() const { return columns_ * group_lanes; }

  SplitLaw split_;
  double disorder_;
  std::size_t columns_;
  RowNoise noise_;
  AlignedArray<double> weight_, next_, q_;
};

}  // namespace

std::unique_ptr<RowModel> make_q_model(const QModelSpec& spec, int columns) {
  return std::make_unique<QModel>(spec, columns);
}

}  // namespace granuscope
#endif
