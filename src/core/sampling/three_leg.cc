#include "sampling/row_model.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/three_leg.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

/// Numbers of a law: what makes a share of the middle leg from a uniform number.
#ifndef GRANUSCOPE_THREE_LEG_LAW
#define GRANUSCOPE_THREE_LEG_LAW
namespace granuscope {
struct ThreeLegLaw {
  MiddleLaw law;
  double lowest, width;  ///< free, clipped: p = lowest + width u
  double share;          ///< positive
};
}  // namespace granuscope
#endif

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// F_t is `weight`, F_x / tan psi is `push`. The middle leg carries m = p F_t, the outer ones V_+- = (F_t - m +-
/// push)/2; the bead below gets F_t' = m + V_+ (from its left) + V_- (from its right) and push' = V_+ - V_-.
template <MiddleLaw law, bool with_sums>
void HandDown(const ThreeLegLaw& numbers, const double* HWY_RESTRICT weight, const double* HWY_RESTRICT push,
              const double* HWY_RESTRICT uniforms, std::size_t columns, double* HWY_RESTRICT next_weight,
              double* HWY_RESTRICT next_push, RowSums* sums) {
  const hn::CappedTag<double, group_lanes> d;
  using V = hn::Vec<decltype(d)>;
  const V half = hn::Set(d, 0.5), one = hn::Set(d, 1.0), zero = hn::Zero(d);
  const V lowest = hn::Set(d, numbers.lowest), width = hn::Set(d, numbers.width), share = hn::Set(d, numbers.share);
  const V least_weight = hn::Set(d, 1e-300);  // nothing is divided by 0; of nothing, any share is nothing
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    V m_before = zero, plus_before = zero, plus_two_before = zero;
    V thrust = zero, middle = zero, pulling = zero;
    // Bead i completes the one below bead i - 1; the first two come again at the end, since the row is a ring.
    for (std::size_t t = 0; t < columns + 2; ++t) {
      const std::size_t at = (t < columns ? t : t - columns) * group_lanes + k;
      const V w = hn::LoadU(d, weight + at), h = hn::LoadU(d, push + at), u = hn::LoadU(d, uniforms + at);
      V m, p = zero;
      auto nothing_left = hn::Lt(w, zero);
      if constexpr (law == MiddleLaw::positive) {
        m = hn::Mul(hn::Mul(share, u), hn::Sub(w, hn::Abs(h)));
        if constexpr (with_sums) p = hn::Div(m, hn::Max(w, least_weight));
      } else if constexpr (law == MiddleLaw::free) {
        p = hn::Add(lowest, hn::Mul(width, u));
        m = hn::Mul(p, w);
      } else {
        const V p_max = hn::Max(zero, hn::Sub(one, hn::Div(hn::Abs(h), hn::Max(w, least_weight))));
        const V high = hn::Min(hn::Add(lowest, width), p_max);
        nothing_left = hn::Lt(high, lowest);
        p = hn::IfThenElse(nothing_left, p_max, hn::Add(lowest, hn::Mul(u, hn::Sub(high, lowest))));
        m = hn::Mul(p, w);
      }
      const V outer = hn::Sub(w, m);
      const V plus = hn::Mul(half, hn::Add(outer, h)), minus = hn::Sub(outer, plus);
      if (with_sums && t < columns) {
        thrust = hn::Add(thrust, outer);
        middle = hn::Add(middle, p);
        if constexpr (law == MiddleLaw::free) nothing_left = hn::Lt(hn::Min(plus, minus), zero);
        pulling = hn::Add(pulling, hn::IfThenElseZero(nothing_left, one));
      }
      if (t >= 2) {
        const std::size_t below = (t - 1 < columns ? t - 1 : t - 1 - columns) * group_lanes + k;
        hn::StoreU(hn::Add(m_before, hn::Add(plus_two_before, minus)), d, next_weight + below);
        hn::StoreU(hn::Sub(plus_two_before, minus), d, next_push + below);
      }
      m_before = m;
      plus_two_before = plus_before;
      plus_before = plus;
    }
    if constexpr (with_sums) {
      hn::StoreU(thrust, d, sums->thrust.data() + k);
      hn::StoreU(middle, d, sums->extras[0].data() + k);
      hn::StoreU(pulling, d, sums->extras[1].data() + k);
    }
  }
}

template <MiddleLaw law>
void HandDownBy(const ThreeLegLaw& numbers, const double* weight, const double* push, const double* uniforms,
                std::size_t columns, double* next_weight, double* next_push, RowSums* sums) {
  if (sums != nullptr) {
    HandDown<law, true>(numbers, weight, push, uniforms, columns, next_weight, next_push, sums);
  } else {
    HandDown<law, false>(numbers, weight, push, uniforms, columns, next_weight, next_push, sums);
  }
}

void HandDownLegs(const ThreeLegLaw& numbers, const double* weight, const double* push, const double* uniforms,
                  std::size_t columns, double* next_weight, double* next_push, RowSums* sums) {
  switch (numbers.law) {
    case MiddleLaw::free:
      return HandDownBy<MiddleLaw::free>(numbers, weight, push, uniforms, columns, next_weight, next_push, sums);
    case MiddleLaw::positive:
      return HandDownBy<MiddleLaw::positive>(numbers, weight, push, uniforms, columns, next_weight, next_push, sums);
    case MiddleLaw::clipped:
      return HandDownBy<MiddleLaw::clipped>(numbers, weight, push, uniforms, columns, next_weight, next_push, sums);
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

HWY_EXPORT(HandDownLegs);

namespace {

class ThreeLeg final : public RowModel {
 public:
  ThreeLeg(const ThreeLegSpec& spec, int columns)
      : law_{spec.law, spec.middle - spec.noise, 2 * spec.noise, spec.share},
        columns_(static_cast<std::size_t>(columns)),
        noise_(columns, {spec.cell_columns, spec.cell_rows}) {
    for (AlignedArray<double>* row : {&weight_, &push_, &next_weight_, &next_push_}) {
      *row = aligned_array<double>(columns_ * group_lanes);
    }
  }

  void begin(std::uint64_t seed, const LaneSamples& samples, const double* loads) override {
    noise_.begin(seed, samples);
    std::copy_n(loads, columns_ * group_lanes, weight_.get());
    std::fill_n(push_.get(), columns_ * group_lanes, 0.0);
  }
  const double* weight() const override { return weight_.get(); }
  const double* horizontal() override { return push_.get(); }

  void hand_down(int row, RowSums* sums) override {
    HWY_DYNAMIC_DISPATCH(HandDownLegs)
    (law_, weight_.get(), push_.get(), noise_.row(row), columns_, next_weight_.get(), next_push_.get(), sums);
    std::swap(weight_, next_weight_);
    std::swap(push_, next_push_);
  }

  std::uint64_t uniforms(int rows) const override { return noise_.drawn(rows); }

 private:
  ThreeLegLaw law_;
  std::size_t columns_;
  RowNoise noise_;
  AlignedArray<double> weight_, push_, next_weight_, next_push_;
};

}  // namespace

std::unique_ptr<RowModel> make_three_leg(const ThreeLegSpec& spec, int columns) {
  return std::make_unique<ThreeLeg>(spec, columns);
}

}  // namespace granuscope
#endif
