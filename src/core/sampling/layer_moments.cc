#include "sampling/layer_moments.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/layer_moments.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Eight piles.
LayerMoments MeasureGroup(const ForceRow& row, std::size_t beads, double mean, double* weight) {
  const hn::CappedTag<double, group_lanes> d;
  using V = hn::Vec<decltype(d)>;
  LayerMoments sums;
  const V expected = hn::Set(d, mean);
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    V thrust = hn::Zero(d), variance = hn::Zero(d);
    for (std::size_t i = k; i < beads * group_lanes; i += group_lanes) {
      const V w = hn::Add(hn::LoadU(d, row.V_R + i), hn::LoadU(d, row.V_L + i));
      const V H_R = hn::LoadU(d, row.H_R + i), other = hn::LoadU(d, row.H_L + i);
      const V H_L = row.totals ? hn::Sub(other, H_R) : other;
      thrust = hn::Add(thrust, hn::Sub(H_R, H_L));
      const V more = hn::Sub(w, expected);
      variance = hn::Add(variance, hn::Mul(more, more));
      if (weight != nullptr) hn::StoreU(w, d, weight + i);
    }
    hn::StoreU(thrust, d, sums.thrust.data() + k);
    hn::StoreU(variance, d, sums.variance.data() + k);
  }
  return sums;
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <stdexcept>

namespace granuscope {

HWY_EXPORT(MeasureGroup);

LayerMoments measure_row(const ForceRow& row, std::size_t beads, std::size_t stride, double mean, double* weight) {
  if (stride == group_lanes) return HWY_DYNAMIC_DISPATCH(MeasureGroup)(row, beads, mean, weight);
  if (stride != 1 || row.totals) throw std::logic_error("a row of neither one pile nor eight was to be measured");
  LayerMoments sums;
  for (std::size_t i = 0; i < beads; ++i) {
    const double w = row.V_R[i] + row.V_L[i];
    sums.thrust[0] += row.H_R[i] - row.H_L[i];
    sums.variance[0] += (w - mean) * (w - mean);
    if (weight != nullptr) weight[i] = w;
  }
  return sums;
}

}  // namespace granuscope
#endif
