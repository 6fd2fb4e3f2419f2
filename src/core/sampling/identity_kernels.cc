#include "sampling/identity_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/identity_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

#include "model/lattice.h"

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, group_lanes>;
using V = hn::Vec<Tag>;
constexpr Tag d;

HWY_INLINE void add(std::array<double, group_lanes>& sums, std::size_t k, V value) {
  hn::Store(hn::Add(hn::Load(d, sums.data() + k), value), d, sums.data() + k);
}
HWY_INLINE void widen(std::array<double, group_lanes>& largest, std::size_t k, V value) {
  hn::Store(hn::Max(hn::Load(d, largest.data() + k), value), d, largest.data() + k);
}

/// Whole eights of the row; returns how many entries that were.
std::size_t CheckWeights(const double* HWY_RESTRICT V_R, const double* HWY_RESTRICT V_L, const double* HWY_RESTRICT H_R,
                         std::size_t entries, RowFacts& facts) {
  const std::size_t whole = entries - entries % group_lanes;
  for (std::size_t i = 0; i < whole; i += hn::Lanes(d)) {
    const std::size_t k = i % group_lanes;
    const V weight = hn::Add(hn::LoadU(d, V_R + i), hn::LoadU(d, V_L + i));
    add(facts.weight_sum, k, weight);
    widen(facts.largest_weight, k, weight);
    const V H = hn::Abs(hn::LoadU(d, H_R + i));
    widen(facts.largest_H, k, H);
    add(facts.finite_sum, k, H);
  }
  return whole;
}

template <bool totals>
HWY_INLINE V horizontal(const double* H_R, const double* H_L, std::size_t i) {
  const V other = hn::LoadU(d, H_L + i);
  if constexpr (totals) return other;
  return hn::Add(hn::LoadU(d, H_R + i), other);
}

template <bool totals>
std::size_t CheckSome(const CheckedBeads& beads, std::size_t entries, RowFacts& facts) {
  const std::size_t whole = entries - entries % group_lanes, lanes = hn::Lanes(d);
  const V cotangent = hn::Set(d, beads.cotangent), gain = hn::Set(d, beads.gain);
  for (std::size_t k = 0; k < group_lanes; k += lanes) {
    V weight_sum = hn::Load(d, facts.weight_sum.data() + k), finite_sum = hn::Load(d, facts.finite_sum.data() + k);
    V largest_weight = hn::Load(d, facts.largest_weight.data() + k);
    V largest_H = hn::Load(d, facts.largest_H.data() + k);
    V largest_residual = hn::Load(d, facts.largest_residual.data() + k);
    for (std::size_t i = k; i < whole; i += group_lanes) {
      const V weight = hn::Add(hn::LoadU(d, beads.V_R + i), hn::LoadU(d, beads.V_L + i));
      const V above = hn::Add(hn::LoadU(d, beads.V_R_above + i), hn::LoadU(d, beads.V_L_above + i));
      const V left = horizontal<totals>(beads.H_R_left, beads.H_L_left, i);
      const V right = horizontal<totals>(beads.H_R_right, beads.H_L_right, i);
      const V residual =
          hn::Abs(hn::Sub(weight, hn::Add(hn::Add(above, gain), hn::Mul(cotangent, hn::Sub(left, right)))));
      weight_sum = hn::Add(weight_sum, weight);
      const V H = hn::Abs(hn::LoadU(d, beads.H_R + i));
      finite_sum = hn::Add(finite_sum, hn::Add(residual, H));
      largest_weight = hn::Max(largest_weight, weight);
      largest_H = hn::Max(largest_H, H);
      largest_residual = hn::Max(largest_residual, residual);
    }
    hn::Store(weight_sum, d, facts.weight_sum.data() + k);
    hn::Store(finite_sum, d, facts.finite_sum.data() + k);
    hn::Store(largest_weight, d, facts.largest_weight.data() + k);
    hn::Store(largest_H, d, facts.largest_H.data() + k);
    hn::Store(largest_residual, d, facts.largest_residual.data() + k);
  }
  return whole;
}

std::size_t CheckBeads(const CheckedBeads& beads, std::size_t entries, RowFacts& facts) {
  return beads.totals ? CheckSome<true>(beads, entries, facts) : CheckSome<false>(beads, entries, facts);
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace granuscope {

HWY_EXPORT(CheckWeights);
HWY_EXPORT(CheckBeads);

void check_weights(const double* V_R, const double* V_L, const double* H_R, std::size_t entries, RowFacts& facts) {
  for (std::size_t i = HWY_DYNAMIC_DISPATCH(CheckWeights)(V_R, V_L, H_R, entries, facts); i < entries; ++i) {
    const std::size_t k = i % group_lanes;
    facts.weight_sum[k] += V_R[i] + V_L[i];
    facts.largest_weight[k] = std::max(facts.largest_weight[k], V_R[i] + V_L[i]);
    facts.largest_H[k] = std::max(facts.largest_H[k], std::abs(H_R[i]));
    facts.finite_sum[k] += std::abs(H_R[i]);
  }
}

void check_beads(const CheckedBeads& beads, std::size_t entries, RowFacts& facts) {
  for (std::size_t i = HWY_DYNAMIC_DISPATCH(CheckBeads)(beads, entries, facts); i < entries; ++i) {
    const std::size_t k = i % group_lanes;
    const double weight = beads.V_R[i] + beads.V_L[i];
    const double left = beads.H_R_left[i] + beads.H_L_left[i], right = beads.H_R_right[i] + beads.H_L_right[i];
    const double residual =
        std::abs(weight - (beads.V_R_above[i] + beads.V_L_above[i] + beads.gain + beads.cotangent * (left - right)));
    facts.weight_sum[k] += weight;
    facts.finite_sum[k] += residual + std::abs(beads.H_R[i]);
    facts.largest_weight[k] = std::max(facts.largest_weight[k], weight);
    facts.largest_H[k] = std::max(facts.largest_H[k], std::abs(beads.H_R[i]));
    facts.largest_residual[k] = std::max(facts.largest_residual[k], residual);
  }
}

}  // namespace granuscope
#endif
