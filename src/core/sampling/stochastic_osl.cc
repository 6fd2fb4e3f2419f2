#include "sampling/row_model.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/stochastic_osl.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

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
#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <cmath>

#include "sampling/row_noise.h"

namespace granuscope {

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

std::unique_ptr<RowModel> make_stochastic_osl(const StochasticOslSpec& spec, int columns) {
  return std::make_unique<StochasticOsl>(spec, columns);
}

}  // namespace granuscope
#endif
