#include "sampling/row_model.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/row_models.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

#include "sampling/philox-inl.h"

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

/// One step: h_{j+1/2} -= ratio (s_{j+1} - s_j), s = eta (1 + v) w, with v = lowest + width u of the bead that node j
/// lies in; then w_j -= ratio (h_{j+1/2} - h_{j-1/2}), in one pass, since node j + 1 needs nothing of the old w_j.
void StepNodes(const double* HWY_RESTRICT numbers, double lowest, double width, double eta, double ratio,
               std::size_t columns, std::size_t grid, double* HWY_RESTRICT weight, double* HWY_RESTRICT push) {
  const hn::CappedTag<double, group_lanes> d;
  using V = hn::Vec<decltype(d)>;
  const V low = hn::Set(d, lowest), wide = hn::Set(d, width), one = hn::Set(d, 1.0);
  const V eta_ratio = hn::Set(d, eta * ratio), r = hn::Set(d, ratio);
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    const auto stiffness = [&](std::size_t bead) {
      const V v = hn::Add(low, hn::Mul(wide, hn::LoadU(d, numbers + bead * group_lanes + k)));
      return hn::Mul(eta_ratio, hn::Add(one, v));
    };
    V here = stiffness(0), w = hn::LoadU(d, weight + k), s = hn::Mul(here, w);
    const V first_w = w, first_s = s;
    V first_h = hn::Zero(d), before = hn::Zero(d);
    std::size_t at = k;
    // The last node is followed by the first one as it was.
    const auto next = [&](V w_next, V s_next) {
      const V h = hn::Sub(hn::LoadU(d, push + at), hn::Sub(s_next, s));
      hn::StoreU(h, d, push + at);
      if (at == k) {
        first_h = h;
      } else {
        hn::StoreU(hn::Sub(w, hn::Mul(r, hn::Sub(h, before))), d, weight + at);
      }
      before = h;
      w = w_next;
      s = s_next;
      at += group_lanes;
    };
    for (std::size_t bead = 0; bead < columns; ++bead) {
      for (std::size_t node = 1; node < grid; ++node) {
        const V w_next = hn::LoadU(d, weight + at + group_lanes);
        next(w_next, hn::Mul(here, w_next));
      }
      if (bead + 1 == columns) break;
      here = stiffness(bead + 1);
      const V w_next = hn::LoadU(d, weight + at + group_lanes);
      next(w_next, hn::Mul(here, w_next));
    }
    next(first_w, first_s);
    hn::StoreU(hn::Sub(first_w, hn::Mul(r, hn::Sub(first_h, before))), d, weight + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <Random123/philox.h>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "support/error.h"
#include "support/progress.h"

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

HWY_EXPORT(StepNodes);

namespace {

/// d_z sigma_zz = -d_x sigma_xz, d_z sigma_xz = -d_x sigma_xx on staggered nodes, explicit and of second order. Stable
/// while eta (1 + v) (dz/dx)^2 <= 1: with dz/dx = sqrt(3)/2 and eta = 1/3 up to v = 3. Weight is conserved exactly.
class StochasticOsl final : public RowModel {
 public:
  StochasticOsl(const StochasticOslSpec& spec, int columns)
      : disorder_(spec.disorder),
        gaussian_(spec.noise == NoiseLaw::gaussian && spec.disorder > 0),
        lowest_(gaussian_ ? 0 : -std::sqrt(3.0) * spec.disorder),
        width_(gaussian_ ? 1 : 2 * std::sqrt(3.0) * spec.disorder),
        columns_(static_cast<std::size_t>(columns)),
        grid_(static_cast<std::size_t>(spec.grid)),
        noise_(columns, {spec.cell_columns, spec.cell_rows}),
        beads_(aligned_array<double>(columns_ * group_lanes)),
        weight_(aligned_array<double>(nodes() * group_lanes)),
        push_(aligned_array<double>(nodes() * group_lanes)) {
    if (gaussian_) gaussian_noise_ = aligned_array<double>(columns_ * group_lanes);
  }

  void begin(std::uint64_t seed, const LaneSamples& samples, const double* loads) override {
    noise_.begin(seed, samples);
    for (std::size_t j = 0; j < nodes(); ++j) {
      std::copy_n(loads + j / grid_ * group_lanes, group_lanes, weight_.get() + j * group_lanes);
    }
    std::fill_n(push_.get(), nodes() * group_lanes, 0.0);
    average_nodes();
  }
  const double* weight() const override { return beads_.get(); }
  /// The mean over each bead, of fluxes on both sides of its nodes so that it is even about the bead's centre.
  const double* horizontal() override {
    if (horizontal_ == nullptr) horizontal_ = aligned_array<double>(columns_ * group_lanes);
    const auto flux = [this](std::size_t node, std::size_t k) { return push_[node * group_lanes + k]; };
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::size_t first = i * grid_, before = first == 0 ? nodes() - 1 : first - 1;
      for (std::size_t k = 0; k < group_lanes; ++k) {
        double sum = (flux(before, k) + flux(first + grid_ - 1, k)) / 2;
        for (std::size_t node = first; node + 1 < first + grid_; ++node) sum += flux(node, k);
        horizontal_[i * group_lanes + k] = sum / static_cast<double>(grid_);
      }
    }
    return horizontal_.get();
  }

  void hand_down(int row, RowSums* sums) override {
    const double* numbers = noise_.row(row);
    if (gaussian_) numbers = make_gaussian(numbers);
    // The flux within the row is the mean of those at its ends: weight leaves stiff places as long as they last.
    if (sums != nullptr) add_half_thrust(numbers, *sums);
    for (std::size_t step = 0; step < grid_; ++step) {
      HWY_DYNAMIC_DISPATCH(StepNodes)
      (numbers, lowest_, width_, eta, ratio, columns_, grid_, weight_.get(), push_.get());
    }
    average_nodes();
    if (sums != nullptr) add_half_thrust(numbers, *sums);
  }

  std::uint64_t uniforms(int rows) const override { return noise_.drawn(rows); }

 private:
  static constexpr double eta = 1.0 / 3, ratio = sqrt3 / 2;

  std::size_t nodes() const { return columns_ * grid_; }

  /// Of each bead, from its nodes.
  void average_nodes() {
    for (std::size_t i = 0; i < columns_; ++i) {
      for (std::size_t k = 0; k < group_lanes; ++k) {
        double sum = 0;
        for (std::size_t node = 0; node < grid_; ++node) sum += weight_[(i * grid_ + node) * group_lanes + k];
        beads_[i * group_lanes + k] = sum / static_cast<double>(grid_);
      }
    }
  }

  /// v of uniform numbers, by the inverse distribution function between -1 and 1.
  const double* make_gaussian(const double* uniforms) {
    const double below = gsl_cdf_ugaussian_P(-1 / disorder_), between = 1 - 2 * below;
    for (std::size_t i = 0; i < columns_ * group_lanes; ++i) {
      gaussian_noise_[i] = disorder_ * gsl_cdf_ugaussian_Pinv(below + between * uniforms[i]);
    }
    return gaussian_noise_.get();
  }

  void add_half_thrust(const double* numbers, RowSums& sums) const {
    for (std::size_t i = 0; i < columns_; ++i) {
      for (std::size_t k = 0; k < group_lanes; ++k) {
        const double v = lowest_ + width_ * numbers[i * group_lanes + k];
        sums.thrust[k] += (1 + v) / 2 * beads_[i * group_lanes + k];
      }
    }
  }

  double disorder_;
  bool gaussian_;
  double lowest_, width_;  ///< v = lowest + width times the number of the bead
  std::size_t columns_, grid_;
  RowNoise noise_;
  AlignedArray<double> beads_, weight_, push_, horizontal_, gaussian_noise_;
};

}  // namespace

std::unique_ptr<RowModel> make_row_model(const ModelSpec& model, int columns) {
  switch (model.name) {
    case ModelName::q_model:
      return std::make_unique<QModel>(model.q_model, columns);
    case ModelName::three_leg:
      return std::make_unique<ThreeLeg>(model.three_leg, columns);
    case ModelName::stochastic_osl:
      return std::make_unique<StochasticOsl>(model.stochastic_osl, columns);
    case ModelName::frictional_beads:
    case ModelName::diluted_beads:
      break;
  }
  throw std::logic_error("beads are no model that hands forces down row by row");
}

RowModelSampler::RowModelSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice),
      spec_(spec),
      model_(make_row_model(spec.model, lattice.columns())),
      layers_(static_cast<std::size_t>(lattice.layers())),
      place_(static_cast<std::size_t>(lattice.layers())),
      load_(aligned_array<double>(static_cast<std::size_t>(lattice.columns()) * group_lanes)) {
  std::iota(layers_.begin(), layers_.end(), 0);
  std::iota(place_.begin(), place_.end(), 0);
}

double RowModelSampler::memory(const Lattice& lattice, const KeptLayers* kept) {
  const double rows =
      kept == nullptr ? lattice.layers() : static_cast<double>(kept->layers.size()) * (kept->horizontal ? 2 : 1);
  const double rows_of_model = 8 * 17;  // and of its noise
  return 8 * static_cast<double>(group_lanes) * (rows + rows_of_model) * lattice.columns();
}

std::optional<SamplingFailure> RowModelSampler::draw(std::uint64_t, std::span<const double>, Pile&) {
  throw InputError(
      "a pile of the model {} has no contacts as beads have them, so that it cannot be stored, "
      "rendered or loaded twice; measure it by an ensemble",
      name_of(spec_.model.name));
}

void RowModelSampler::keep_layers(const KeptLayers& kept) {
  layers_ = kept.layers;
  horizontal_ = kept.horizontal;
  std::fill(place_.begin(), place_.end(), -1);
  for (std::size_t l = 0; l < layers_.size(); ++l) place_[static_cast<std::size_t>(layers_[l])] = static_cast<int>(l);
  kept_.clear();
}

RowModelSampler::Kept& RowModelSampler::room(std::size_t group) {
  while (kept_.size() <= group) {
    Kept& kept = kept_.emplace_back();
    const std::size_t size = layers_.size() * static_cast<std::size_t>(lattice_.columns()) * group_lanes;
    kept.weights = aligned_array<double>(size);
    if (horizontal_) {
      kept.horizontal = aligned_array<double>(size);
      std::fill_n(kept.horizontal.get(), size, 0.0);  // as it stays in a scalar model
    }
    kept.moments.resize(layers_.size());
    kept.extras.resize(layers_.size() * extra_names(spec_.model).size() * group_lanes);
  }
  return kept_[group];
}

std::span<const PileGroup> RowModelSampler::draw_groups(std::span<const std::uint64_t> samples,
                                                        std::span<const std::span<const double>> loads,
                                                        std::span<std::optional<SamplingFailure>> failures) {
  groups_.clear();
  std::fill(failures.begin(), failures.end(), std::nullopt);
  for (std::size_t done = 0, count = 0; done < samples.size(); done += count) {
    // Runs of consecutive samples, so that two runs of the same ones make groups alike; or of the same one.
    count = 1;
    const std::uint64_t step = done + 1 < samples.size() && samples[done + 1] == samples[done] ? 0 : 1;
    while (count < group_lanes && done + count < samples.size() &&
           samples[done + count] == samples[done] + step * count) {
      ++count;
    }
    throw_if_interrupted();
    LaneSamples lanes;
    for (std::size_t k = 0; k < group_lanes; ++k) lanes[k] = samples[done + std::min(k, count - 1)];
    Kept& kept = room(groups_.size());
    draw_group(lanes, loads.subspan(done, count), kept);
    groups_.push_back({.lattice = lattice_,
                       .stride = group_lanes,
                       .piles = count,
                       .weights = kept.weights.get(),
                       .horizontal = kept.horizontal.get(),
                       .moments = kept.moments,
                       .kept = place_,
                       .loads = loads.subspan(done, count),
                       .residuals = {kept.residuals.data(), count},
                       .extra_names = extra_names(spec_.model),
                       .extras = kept.extras.data(),
                       .mu = 0,
                       .law = name_of(spec_.model.name),
                       .seed = spec_.seed,
                       .first_sample = samples[done],
                       .sample_step = step});
    const auto rows = static_cast<std::uint64_t>(layers_.back()) + 1;
    counts_.tries += count;
    counts_.beads += count * rows * static_cast<std::uint64_t>(lattice_.columns());
    counts_.uniforms += count * model_->uniforms(layers_.back() + 1);
  }
  return groups_;
}

void RowModelSampler::draw_group(const LaneSamples& samples, std::span<const std::span<const double>> loads,
                                 Kept& kept) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  std::array<double, group_lanes> total{};
  for (std::size_t k = 0; k < group_lanes; ++k) {
    const std::span<const double> load = loads[std::min(k, loads.size() - 1)];
    for (std::size_t i = 0; i < columns; ++i) load_[i * group_lanes + k] = load[i];
    total[k] = std::accumulate(load.begin(), load.end(), 0.0);
  }
  kept.residuals = {};
  model_->begin(spec_.seed, samples, load_.get());
  // What is below the last layer that is measured changes nothing above.
  for (int layer = 0; layer <= layers_.back(); ++layer) {
    const int place = place_[static_cast<std::size_t>(layer)];
    if (place < 0) {
      model_->hand_down(layer, nullptr);
      continue;
    }
    const std::size_t to = static_cast<std::size_t>(place) * columns * group_lanes;
    std::copy_n(model_->weight(), columns * group_lanes, kept.weights.get() + to);
    if (horizontal_) {
      const double* const horizontal = model_->horizontal();
      if (horizontal != nullptr) std::copy_n(horizontal, columns * group_lanes, kept.horizontal.get() + to);
    }
    RowSums sums;
    model_->hand_down(layer, &sums);
    keep_row(layer, sums, total, kept);
  }
}

void RowModelSampler::keep_row(int layer, const RowSums& sums, const std::array<double, group_lanes>& total,
                               Kept& kept) const {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  const auto place = static_cast<std::size_t>(place_[static_cast<std::size_t>(layer)]);
  const double* const row = kept.weights.get() + place * columns * group_lanes;
  std::array<double, group_lanes> weight{}, variance{};
  for (std::size_t i = 0; i < columns; ++i) {
    for (std::size_t k = 0; k < group_lanes; ++k) {
      const double w = row[i * group_lanes + k];
      weight[k] += w;
      variance[k] += (w - 1) * (w - 1);
    }
  }
  LayerMoments& moments = kept.moments[place];
  moments.variance = variance;
  const std::size_t extras = extra_names(spec_.model).size();
  for (std::size_t k = 0; k < group_lanes; ++k) {
    // Observables have sqrt(3) of it over the load, which is 1 for beads without friction.
    moments.thrust[k] = sums.thrust[k] / sqrt3;
    const double residual = std::abs(weight[k] - total[k]) / total[k];
    double& worst = kept.residuals[k].weight_sum;
    worst = std::isfinite(residual) ? std::max(worst, residual) : INFINITY;
    for (std::size_t e = 0; e < extras; ++e) {
      kept.extras[(place * extras + e) * group_lanes + k] = sums.extras[e][k] / static_cast<double>(columns);
    }
  }
}

}  // namespace granuscope
#endif
