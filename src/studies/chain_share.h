#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/results.h"
#include "analysis/transport.h"
#include "studies/study.h"

namespace granuscope {

/// Distance from a ray within which a bead counts as part of its chain, in bead diameters.
inline constexpr double chain_half_width = 3;

/// The share of the mean response that lies within `half_width` of the two rays x = +-c z.
struct ChainShareAtDepth {
  int layer = 0;
  double z = 0;
  Estimate share;
  double even_share = 0;  ///< what a response spread evenly over |x| <= c z + half_width would give
};

/// The response of piles of the size of the force-chain picture, gathered along the rays.
struct ChainShare {
  EnsembleSpec spec;
  int layers = 0;  ///< shown; more are computed
  std::uint64_t samples = 0;
  double half_width = chain_half_width;   ///< bead diameters
  Estimate c;                             ///< slope of the rays: c_thrust of these piles
  std::vector<ChainShareAtDepth> depths;  ///< from where the two bands no longer overlap
  Estimate share;                         ///< mean over these depths
  double even_share = 0;                  ///< the same mean of the even shares
  std::uint64_t shown_sample = 0;         ///< of the pile that the picture shows
  Estimate shown;                         ///< its share, without an error
};

/// The share of the mean response within chain_half_width of the rays x = +-c z, with c = c_thrust of the same piles. A
/// bead counts by the part of its width that lies inside. From the depth on where the two bands are as far apart as
/// each is wide. Unknown, with the reason, where the piles are too shallow for that.
ChainShare measure_chain_share(const MeasuredEnsemble& ensemble);

/// Standard deviation of the share between single piles.
double scatter_of_piles(const ChainShare& chains);

/// The same share in the pile that the picture shows, which is drawn for it.
void measure_shown_pile(ChainShare& chains, std::uint64_t sample);

/// The claim that the picture shows two oblique chains: reproduced if the share in the pile shown exceeds both
/// `least_share` and what a response spread evenly between the rays would put there, else not reproduced. It is about
/// one picture, so that the number has no error. None measured: not tested.
Claim judge_force_chains(const std::vector<ChainShare>& measured, double least_share);

/// How much of the response to an overload lies along the two rays, on piles of the size of the force-chain picture.
std::unique_ptr<Study> chain_share_study();

}  // namespace granuscope
