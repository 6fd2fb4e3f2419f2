#pragma once

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "studies/study.h"

namespace granuscope {
/// The thrust ratio under the law rejection, away from top and bottom.
struct RejectionThrust {
  EnsembleSpec spec;
  std::uint64_t samples = 0;            ///< piles that entered
  std::uint64_t failed = 0;             ///< piles that could not be completed
  int first_layer = 0, last_layer = 0;  ///< of the bulk
  Estimate alpha;                       ///< mean over the bulk
  Estimate deficit_over_mu2;            ///< (1 - alpha)/mu^2
  Estimate change_with_depth;           ///< alpha of the lower half of the bulk minus that of its upper half
  Estimate alpha_of_last_layer;
};

/// How the piles are measured out. The less friction, the deeper it takes for top and bottom to be forgotten, and the
/// more beads the law rejection can draw: one pile in ten thousand of 25/mu beads has no failure at mu = 0.3, more
/// below.
struct RejectionThrustSize {
  LatticeSpec lattice;
  int margin;  ///< layers at the top and at the bottom that differ from the bulk, 1.2/mu
};

/// As many beads as the law rejection can draw, at a few widths. For mu up to 0.3; at most 400 layers.
std::vector<RejectionThrustSize> rejection_thrust_sizes(double mu);

/// The thrust ratio in the bulk of uniformly loaded piles, and how much it changes with depth there. Needs every layer
/// recorded, and more of them than twice the margin.
RejectionThrust measure_rejection_thrust(const MeasuredEnsemble& ensemble, int margin);

/// Whether the thrust ratio tends to 1 under the law rejection; `measured`: what was found, if that is known already.
std::unique_ptr<Study> rejection_thrust_study(std::vector<RejectionThrust> measured = {});

/// The standard procedure (estimator "paired") at one friction coefficient: which beads had to draw another number when
/// the overload was added.
struct RedrawnBeads {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< pairs of piles that entered
  std::uint64_t failed = 0;   ///< pairs that could not be completed
  Estimate whole_pile;        ///< share of all beads of the usable layers
  Estimate below_overload;    ///< share of those with |x| <= z
  Estimate failing;           ///< share of all beads of the pile that found no solution; others change with them
  Estimate force;             ///< before the overload acts: mean of the smaller force that these beads hand down
  Estimate relative_force;    ///< that over the mean of all beads at the same depths
  Estimate together;          ///< beads of the rearrangement that a redrawn bead belongs to, its mean over these beads
};

/// The shares of beads that had to draw another number, over the usable layers (0 .. layers - 21) of an ensemble of the
/// estimator "paired", with standard errors by the jackknife over its blocks. All usable layers must be recorded;
/// throws InputError otherwise. Unknown, with the reason, where a block holds no completed pair.
RedrawnBeads measure_redrawn_beads(const MeasuredEnsemble& ensemble);

/// The claim about the share of beads that draw again, "of the order of" two numbers: the share of all beads of the
/// usable layers must lie within a factor of 2 of each, by three standard errors; not reproduced if one lies outside by
/// as much, not tested if one was not measured. The number shown is the one farther off.
Claim judge_redraw_share(const std::vector<RedrawnBeads>& measured);

/// The claim that rearrangements are local and preferably concern small forces, at every friction coefficient measured:
/// the relative force lies below 1 by three standard errors, and a redrawn bead belongs to a rearrangement of at most
/// `most_together` beads on average, by as much.
Claim judge_rearrangements(const std::vector<RedrawnBeads>& measured, double most_together);

/// The standard procedure beside the paper's own: how many beads draw again. On the experiment's lattice, with its
/// overload.
std::unique_ptr<Study> redrawn_beads_study();

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

/// The same share in the pile that the picture shows, which is drawn for it.
void measure_shown_pile(ChainShare& chains, std::uint64_t sample);

/// The claim that the picture shows two oblique chains: reproduced if the share in the pile shown exceeds both
/// `least_share` and what a response spread evenly between the rays would put there, else not reproduced. It is about
/// one picture, so that the number has no error. None measured: not tested.
Claim judge_force_chains(const std::vector<ChainShare>& measured, double least_share);

/// How much of the response to an overload lies along the two rays, on piles of the size of the force-chain picture.
std::unique_ptr<Study> chain_share_study();

}  // namespace granuscope
