#pragma once
#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"
#include "model/lattice.h"

namespace granuscope {

/// Height of the response's peaks, per bead diameter and unit overload: the weight measured within W + 1/2 of
/// x = +-x_p, of beads at the edge in part, over what the fitted shape puts there, times the maximum of that shape. The
/// shape only carries the measured weight from beads to a point. `response` is the mean response of the layer,
/// [columns].
Replicated peak_height(const BlockMeans& response, const Lattice& lattice, int layer, const Replicated& peak,
                       const Replicated& width);

}  // namespace granuscope
