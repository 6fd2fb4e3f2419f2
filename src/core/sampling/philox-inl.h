// Philox4x32-10 (Salmon et al., SC 2011) with one counter in each 64-bit lane. A vector file of Highway: included once
// for every instruction set, so it has no ordinary include guard.
#if defined(GRANUSCOPE_PHILOX_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GRANUSCOPE_PHILOX_INL_H
#undef GRANUSCOPE_PHILOX_INL_H
#else
#define GRANUSCOPE_PHILOX_INL_H
#endif

#include <hwy/highway.h>

#include "sampling/random_key.h"

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {

/// Two uniform numbers a lane.
template <class D>
struct LaneUniforms {
  hwy::HWY_NAMESPACE::Vec<D> first, second;
};

/// The two uniforms of each lane's counter c0..c3, as to_unit_interval makes them. Of every 64-bit word only the low 32
/// bits count: the multiplication reads nothing else, and xor keeps the halves apart.
template <class WordTag, class W>
HWY_INLINE auto philox_uniforms(WordTag word, const PhiloxKeys& keys, W c0, W c1, W c2, W c3) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::Repartition<std::uint32_t, WordTag> d_half;
  const hn::RebindToSigned<WordTag> d_signed;
  const hn::RebindToFloat<WordTag> number;
  const auto multiplier0 = hn::Set(d_half, 0xD2511F53U);
  const auto multiplier1 = hn::Set(d_half, 0xCD9E8D57U);
  HWY_UNROLL(10)
  for (std::size_t round = 0; round < PhiloxKeys::rounds; ++round) {
    const W product0 = hn::MulEven(hn::BitCast(d_half, c0), multiplier0);
    const W product1 = hn::MulEven(hn::BitCast(d_half, c2), multiplier1);
    c0 = hn::Xor3(hn::ShiftRight<32>(product1), c1, hn::Set(word, keys.word0[round]));
    c2 = hn::Xor3(hn::ShiftRight<32>(product0), c3, hn::Set(word, keys.word1[round]));
    c1 = product1;
    c3 = product0;
  }
  const auto to_unit = [&](W low, W high) {
    const W bits =
        hn::ShiftRight<11>(hn::Or(hn::ShiftLeft<32>(high), hn::And(low, hn::Set(word, std::uint64_t{0xFFFFFFFF}))));
    return hn::Mul(hn::ConvertTo(number, hn::BitCast(d_signed, bits)), hn::Set(number, 0x1p-53));
  };
  return LaneUniforms<hn::RebindToFloat<WordTag>>{to_unit(c0, c1), to_unit(c2, c3)};
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#endif
