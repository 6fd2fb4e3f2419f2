#include "sampling/layer_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/layer_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

#include "sampling/philox-inl.h"
#include "sampling/repair_arithmetic-inl.h"

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void FillFirstUniforms(std::uint64_t seed, std::uint32_t sample, int layer, double* HWY_RESTRICT uniforms,
                       std::size_t beads) {
  const hn::ScalableTag<std::uint64_t> d_words;
  const hn::RebindToFloat<decltype(d_words)> d_float;
  const PhiloxKeys keys(seed);
  const auto layers = hn::Set(d_words, static_cast<std::uint64_t>(static_cast<std::uint32_t>(layer)));
  const auto samples = hn::Set(d_words, static_cast<std::uint64_t>(sample));
  const std::size_t calls = (beads + 1) / 2;
  for (std::size_t call = 0; call < calls; call += hn::Lanes(d_words)) {
    // Attempt 0 of the stream of first attempts: beads 2k and 2k + 1 share counter k.
    const auto u = philox_uniforms(d_words, keys, hn::Iota(d_words, static_cast<std::uint64_t>(call)), layers, samples,
                                   hn::Zero(d_words));
    hn::StoreInterleaved2(u.first, u.second, d_float, uniforms + 2 * call);
  }
}

/// All whole vectors of the run; returns how many beads were drawn.
std::size_t DrawBeads(const FrictionCone& friction, const UpperRow& above, const double* HWY_RESTRICT uniforms,
                      std::size_t beads, const LowerRow& out) {
  const std::size_t lanes = hn::Lanes(d);
  const ConeOf<V> cone(friction);
  const V half_weight = hn::Set(d, above.half_weight);
  std::size_t i = 0;
  for (; i + lanes <= beads; i += lanes) {
    const IncomingOf<V> in{hn::LoadU(d, above.V_UL + i) + half_weight, hn::LoadU(d, above.V_UR + i) + half_weight,
                           hn::LoadU(d, above.H_UL + i) + hn::LoadU(d, above.H_UR + i)};
    const DrawnBeadOf<V> bead = draw_bead(cone, in, hn::LoadU(d, uniforms + i));
    hn::StoreU(bead.out.V_R, d, out.V_R + i);
    hn::StoreU(bead.out.V_L, d, out.V_L + i);
    hn::StoreU(in.H, d, out.H + i);
    hn::StoreU(bead.H_R, d, out.H_R + i);
    hn::StoreU(bead.H_L, d, out.H_L + i);
    hn::StoreU(bead.slack, d, out.slack + i);
  }
  return i;
}

void LaterNumbers(const PhiloxKeys& keys, std::uint32_t sample, int layer, const std::uint32_t* HWY_RESTRICT bead,
                  const std::uint32_t* HWY_RESTRICT attempt, double* HWY_RESTRICT number) {
  const hn::CappedTag<std::uint64_t, attempts_at_once> d_words;
  const hn::Rebind<std::uint32_t, decltype(d_words)> d_half;
  const auto layers = hn::Set(d_words, static_cast<std::uint64_t>(static_cast<std::uint32_t>(layer)));
  const auto samples = hn::Set(d_words, static_cast<std::uint64_t>(sample));
  for (std::size_t i = 0; i < attempts_at_once; i += hn::Lanes(d_words)) {
    const auto attempts = hn::PromoteTo(d_words, hn::LoadU(d_half, attempt + i));
    const auto u =
        philox_uniforms(d_words, keys, hn::PromoteTo(d_words, hn::LoadU(d_half, bead + i)), layers, samples,
                        hn::Or(hn::ShiftLeft<8>(attempts), hn::Set(d_words, std::uint64_t{later_attempt_stream})));
    hn::StoreU(u.first, hn::RebindToFloat<decltype(d_words)>(), number + i);
  }
}

void FindFailing(const double* HWY_RESTRICT slack, std::size_t beads, std::uint64_t* HWY_RESTRICT words) {
  const std::size_t lanes = hn::Lanes(d);
  const auto zero = hn::Zero(d);
  for (std::size_t word = 0; word < (beads + 63) / 64; ++word) words[word] = 0;
  std::size_t i = 0;
  for (; i + lanes <= beads; i += lanes) {
    std::uint8_t bits[8] = {};  // StoreMaskBits writes at most 8 bytes
    hn::StoreMaskBits(d, hn::Not(hn::Ge(hn::LoadU(d, slack + i), zero)), bits);
    words[i / 64] |= static_cast<std::uint64_t>(bits[0]) << (i % 64);
  }
  for (; i < beads; ++i) words[i / 64] |= static_cast<std::uint64_t>(!(slack[i] >= 0)) << (i % 64);
}

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

/// Eight piles.
LayerMoments MeasureGroup(const ForceRow& row, std::size_t beads, double mean, double* weight) {
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
#include <Random123/philox.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "model/equilibrium.h"

namespace granuscope {

HWY_EXPORT(FillFirstUniforms);
HWY_EXPORT(DrawBeads);
HWY_EXPORT(LaterNumbers);
HWY_EXPORT(FindFailing);

namespace {

thread_local int plain_kernels = 0;

}  // namespace

PlainKernels::PlainKernels() { ++plain_kernels; }
PlainKernels::~PlainKernels() { --plain_kernels; }
bool PlainKernels::in_use() { return plain_kernels > 0; }

void fill_first_uniforms(std::uint64_t seed, std::uint32_t sample, int layer, double* uniforms, std::size_t beads) {
  if (plain_kernels > 0) return fill_first_uniforms_plain(seed, sample, layer, uniforms, beads);
  HWY_DYNAMIC_DISPATCH(FillFirstUniforms)(seed, sample, layer, uniforms, beads);
}

void fill_first_uniforms_plain(std::uint64_t seed, std::uint32_t sample, int layer, double* uniforms,
                               std::size_t beads) {
  const r123::Philox4x32::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  for (std::size_t bead = 0; bead < beads; bead += 2) {
    const r123::Philox4x32::ctr_type counter{
        {static_cast<std::uint32_t>(bead / 2), static_cast<std::uint32_t>(layer), sample, 0}};
    const auto words = r123::Philox4x32()(counter, key);
    uniforms[bead] = to_unit_interval(words[0], words[1]);
    if (bead + 1 < beads) uniforms[bead + 1] = to_unit_interval(words[2], words[3]);
  }
}

void later_numbers(const PhiloxKeys& keys, std::uint32_t sample, int layer,
                   const std::array<std::uint32_t, attempts_at_once>& bead,
                   const std::array<std::uint32_t, attempts_at_once>& attempt,
                   std::array<double, attempts_at_once>& number) {
  HWY_DYNAMIC_DISPATCH(LaterNumbers)(keys, sample, layer, bead.data(), attempt.data(), number.data());
}

void draw_beads_plain(const FrictionCone& cone, const UpperRow& above, const double* uniforms, std::size_t beads,
                      const LowerRow& out) {
  for (std::size_t i = 0; i < beads; ++i) {
    const Incoming in = with_weight({above.V_UL[i], above.V_UR[i], above.H_UL[i] + above.H_UR[i]}, above.half_weight);
    const auto bead = draw_bead(cone, in, uniforms[i]);
    out.V_R[i] = bead.out.V_R;
    out.V_L[i] = bead.out.V_L;
    out.H[i] = in.H;
    out.H_R[i] = bead.H_R;
    out.H_L[i] = bead.H_L;
    out.slack[i] = bead.slack;
  }
}

void draw_beads(const FrictionCone& cone, const UpperRow& above, const double* uniforms, std::size_t beads,
                const LowerRow& out) {
  const std::size_t done = plain_kernels > 0 ? 0 : HWY_DYNAMIC_DISPATCH(DrawBeads)(cone, above, uniforms, beads, out);
  draw_beads_plain(cone,
                   {above.V_UL + done, above.V_UR + done, above.H_UL + done, above.H_UR + done, above.half_weight},
                   uniforms + done, beads - done,
                   {out.V_R + done, out.V_L + done, out.H + done, out.H_R + done, out.H_L + done, out.slack + done});
}

void find_failing(const double* slack, std::size_t beads, std::uint64_t* words) {
  if (plain_kernels > 0) return find_failing_plain(slack, beads, words);
  HWY_DYNAMIC_DISPATCH(FindFailing)(slack, beads, words);
}

void find_failing_plain(const double* slack, std::size_t beads, std::uint64_t* words) {
  for (std::size_t i = 0; i < beads; ++i) {
    if (i % 64 == 0) words[i / 64] = 0;
    words[i / 64] |= static_cast<std::uint64_t>(!(slack[i] >= 0)) << (i % 64);
  }
}

std::string instruction_set() { return hwy::TargetName(hwy::SupportedAndGeneratedTargets().front()); }

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
