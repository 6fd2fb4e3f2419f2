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

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <Random123/philox.h>

#include "model/equilibrium.h"
#include "sampling/random_key.h"

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

}  // namespace granuscope
#endif
