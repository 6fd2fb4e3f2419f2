#include "ensemble/group_fourier.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ensemble/group_fourier.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

const hn::CappedTag<double, group_lanes> d;
using V = hn::Vec<decltype(d)>;

struct Complex {
  V re, im;
};
HWY_INLINE Complex operator+(Complex a, Complex b) { return {hn::Add(a.re, b.re), hn::Add(a.im, b.im)}; }
HWY_INLINE Complex operator-(Complex a, Complex b) { return {hn::Sub(a.re, b.re), hn::Sub(a.im, b.im)}; }
/// Products are rounded before they are added, on every machine.
HWY_INLINE Complex operator*(Complex a, Complex b) {
  return {hn::Sub(hn::Mul(a.re, b.re), hn::Mul(a.im, b.im)), hn::Add(hn::Mul(a.re, b.im), hn::Mul(a.im, b.re))};
}
HWY_INLINE Complex scaled(double s, Complex a) { return {hn::Mul(hn::Set(d, s), a.re), hn::Mul(hn::Set(d, s), a.im)}; }
/// -i a
HWY_INLINE Complex turned(Complex a) { return {a.im, hn::Neg(a.re)}; }

/// exp(-2 pi i k / size)
HWY_INLINE Complex root(const FourierStage& stage, std::size_t k) {
  return {hn::Set(d, stage.cosine[k]), hn::Set(d, -stage.sine[k])};
}
HWY_INLINE Complex load(const FourierStage& stage, std::size_t bead, std::size_t lane) {
  const std::size_t at = bead * group_lanes + lane;
  return {hn::Load(d, stage.from_re + at), hn::Load(d, stage.from_im + at)};
}
HWY_INLINE void store(const FourierStage& stage, Complex z, std::size_t bead, std::size_t lane) {
  const std::size_t at = bead * group_lanes + lane;
  hn::Store(z.re, d, stage.to_re + at);
  hn::Store(z.im, d, stage.to_im + at);
}

struct Radix2 {
  static constexpr std::size_t factor = 2;
  HWY_INLINE static void transform(Complex* a) {
    const Complex sum = a[0] + a[1];
    a[1] = a[0] - a[1];
    a[0] = sum;
  }
};

struct Radix3 {
  static constexpr std::size_t factor = 3;
  HWY_INLINE static void transform(Complex* a) {
    constexpr double half_root = 0.86602540378443864676;  // sqrt(3)/2
    const Complex sum = a[1] + a[2], turn = turned(scaled(half_root, a[1] - a[2]));
    const Complex middle = a[0] - scaled(0.5, sum);
    a[0] = a[0] + sum;
    a[1] = middle + turn;
    a[2] = middle - turn;
  }
};

struct Radix4 {
  static constexpr std::size_t factor = 4;
  HWY_INLINE static void transform(Complex* a) {
    const Complex even = a[0] + a[2], odd = a[1] + a[3], even_less = a[0] - a[2], turn = turned(a[1] - a[3]);
    a[0] = even + odd;
    a[1] = even_less + turn;
    a[2] = even - odd;
    a[3] = even_less - turn;
  }
};

struct Radix5 {
  static constexpr std::size_t factor = 5;
  HWY_INLINE static void transform(Complex* a) {
    constexpr double cos1 = 0.30901699437494742410, cos2 = -0.80901699437494742410;  // of 72 and 144 degrees
    constexpr double sin1 = 0.95105651629515357212, sin2 = 0.58778525229247312917;
    const Complex s1 = a[1] + a[4], s2 = a[2] + a[3], d1 = a[1] - a[4], d2 = a[2] - a[3];
    const Complex m1 = a[0] + scaled(cos1, s1) + scaled(cos2, s2), m2 = a[0] + scaled(cos2, s1) + scaled(cos1, s2);
    const Complex t1 = turned(scaled(sin1, d1) + scaled(sin2, d2)), t2 = turned(scaled(sin2, d1) - scaled(sin1, d2));
    a[0] = a[0] + s1 + s2;
    a[1] = m1 + t1;
    a[2] = m2 + t2;
    a[3] = m2 - t2;
    a[4] = m1 - t1;
  }
};

template <typename Radix>
void SplitBy(const FourierStage& stage) {
  constexpr std::size_t f = Radix::factor;
  const std::size_t parts = stage.length / f, turn = stage.size / stage.length;
  for (std::size_t p = 0; p < parts; ++p) {
    Complex roots[f];
    for (std::size_t t = 1; t < f; ++t) roots[t] = root(stage, p * t * turn % stage.size);
    for (std::size_t q = 0; q < stage.stride; ++q) {
      for (std::size_t lane = 0; lane < group_lanes; lane += hn::Lanes(d)) {
        Complex a[f];
        for (std::size_t j = 0; j < f; ++j) a[j] = load(stage, q + stage.stride * (p + j * parts), lane);
        Radix::transform(a);
        store(stage, a[0], q + stage.stride * f * p, lane);
        for (std::size_t t = 1; t < f; ++t) store(stage, a[t] * roots[t], q + stage.stride * (f * p + t), lane);
      }
    }
  }
}

/// Any factor, by the definition.
void SplitByAny(const FourierStage& stage) {
  const std::size_t f = stage.factor, parts = stage.length / f, turn = stage.size / stage.length;
  for (std::size_t p = 0; p < parts; ++p) {
    for (std::size_t q = 0; q < stage.stride; ++q) {
      for (std::size_t lane = 0; lane < group_lanes; lane += hn::Lanes(d)) {
        for (std::size_t t = 0; t < f; ++t) {
          Complex sum = load(stage, q + stage.stride * p, lane);
          for (std::size_t j = 1; j < f; ++j) {
            sum =
                sum + load(stage, q + stage.stride * (p + j * parts), lane) * root(stage, j * t % f * (stage.size / f));
          }
          store(stage, sum * root(stage, p * t * turn % stage.size), q + stage.stride * (f * p + t), lane);
        }
      }
    }
  }
}

void Split(const FourierStage& stage) {
  switch (stage.factor) {
    case 2:
      return SplitBy<Radix2>(stage);
    case 3:
      return SplitBy<Radix3>(stage);
    case 4:
      return SplitBy<Radix4>(stage);
    case 5:
      return SplitBy<Radix5>(stage);
    default:
      return SplitByAny(stage);
  }
}

void SeparateFields(const double* HWY_RESTRICT re, const double* HWY_RESTRICT im, std::size_t size,
                    std::span<const PhaseFactor> turns, std::size_t stride, double* HWY_RESTRICT fields) {
  for (std::size_t mode = 1; mode <= turns.size(); ++mode, fields += stride) {
    const Complex turn{hn::Set(d, turns[mode - 1].cosine), hn::Set(d, turns[mode - 1].sine)};
    for (std::size_t lane = 0; lane < group_lanes; lane += hn::Lanes(d)) {
      const std::size_t at = mode * group_lanes + lane, mirror = (size - mode) * group_lanes + lane;
      const Complex z{hn::Load(d, re + at), hn::Load(d, im + at)};
      const Complex z_mirror{hn::Load(d, re + mirror), hn::Load(d, im + mirror)};
      const Complex a = scaled(0.5, Complex{hn::Add(z.re, z_mirror.re), hn::Sub(z.im, z_mirror.im)}) * turn;
      const Complex b = scaled(0.5, Complex{hn::Add(z.im, z_mirror.im), hn::Sub(z_mirror.re, z.re)}) * turn;
      hn::Store(a.re, d, fields + lane);
      hn::Store(a.im, d, fields + group_lanes + lane);
      hn::Store(b.re, d, fields + 2 * group_lanes + lane);
      hn::Store(b.im, d, fields + 3 * group_lanes + lane);
    }
  }
}

void AddCorrelations(const double* HWY_RESTRICT fields, const int* HWY_RESTRICT pairs, std::size_t count,
                     double* HWY_RESTRICT sums) {
  constexpr std::size_t layer = correlation_parts * group_lanes;
  for (std::size_t lane = 0; lane < group_lanes; lane += hn::Lanes(d)) {
    double* const to = sums + lane;
    V ww = hn::Load(d, to), HH = hn::Load(d, to + group_lanes);
    V wH = hn::Load(d, to + 2 * group_lanes), Hw = hn::Load(d, to + 3 * group_lanes);
    for (std::size_t i = 0; i < count; i += 2) {
      const double* const base = fields + static_cast<std::size_t>(pairs[i]) * layer + lane;
      const double* const partner = fields + static_cast<std::size_t>(pairs[i + 1]) * layer + lane;
      const V w_re = hn::Load(d, base), w_im = hn::Load(d, base + group_lanes);
      const V H_re = hn::Load(d, base + 2 * group_lanes), H_im = hn::Load(d, base + 3 * group_lanes);
      const V w_re2 = hn::Load(d, partner), w_im2 = hn::Load(d, partner + group_lanes);
      const V H_re2 = hn::Load(d, partner + 2 * group_lanes), H_im2 = hn::Load(d, partner + 3 * group_lanes);
      ww = hn::Add(ww, hn::Add(hn::Mul(w_re2, w_re), hn::Mul(w_im2, w_im)));
      HH = hn::Add(HH, hn::Add(hn::Mul(H_re2, H_re), hn::Mul(H_im2, H_im)));
      wH = hn::Add(wH, hn::Sub(hn::Mul(w_im2, H_re), hn::Mul(w_re2, H_im)));
      Hw = hn::Add(Hw, hn::Sub(hn::Mul(H_im2, w_re), hn::Mul(H_re2, w_im)));
    }
    hn::Store(ww, d, to);
    hn::Store(HH, d, to + group_lanes);
    hn::Store(wH, d, to + 2 * group_lanes);
    hn::Store(Hw, d, to + 3 * group_lanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>
#include <numbers>

namespace granuscope {

HWY_EXPORT(Split);
HWY_EXPORT(SeparateFields);
HWY_EXPORT(AddCorrelations);

GroupFourier::GroupFourier(std::size_t size)
    : size_(size),
      cosine_(aligned_array<double>(size)),
      sine_(aligned_array<double>(size)),
      work_re_(aligned_array<double>(size * group_lanes)),
      work_im_(aligned_array<double>(size * group_lanes)) {
  std::size_t rest = size;
  for (const std::size_t factor : {4, 2, 3, 5}) {
    for (; rest % factor == 0; rest /= factor) factors_.push_back(factor);
  }
  for (std::size_t factor = 7; rest > 1; factor += 2) {
    for (; rest % factor == 0; rest /= factor) factors_.push_back(factor);
  }
  for (std::size_t k = 0; k < size; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(size);
    cosine_[k] = std::cos(angle);
    sine_[k] = std::sin(angle);
  }
}

void GroupFourier::transform(double* re, double* im) {
  double *from_re = re, *from_im = im, *to_re = work_re_.get(), *to_im = work_im_.get();
  std::size_t length = size_, stride = 1;
  for (const std::size_t factor : factors_) {
    const FourierStage stage{factor, length, stride, size_, cosine_.get(), sine_.get(), from_re, from_im, to_re, to_im};
    HWY_DYNAMIC_DISPATCH(Split)(stage);
    std::swap(from_re, to_re);
    std::swap(from_im, to_im);
    length /= factor;
    stride *= factor;
  }
  if (from_re == re) return;
  std::copy_n(from_re, size_ * group_lanes, re);
  std::copy_n(from_im, size_ * group_lanes, im);
}

void separate_fields(const double* re, const double* im, std::size_t size, std::span<const PhaseFactor> turns,
                     std::size_t stride, double* fields) {
  HWY_DYNAMIC_DISPATCH(SeparateFields)(re, im, size, turns, stride, fields);
}

void add_correlations(const double* fields, const std::vector<int>& pairs, double* sums) {
  HWY_DYNAMIC_DISPATCH(AddCorrelations)(fields, pairs.data(), pairs.size(), sums);
}

}  // namespace granuscope
#endif
