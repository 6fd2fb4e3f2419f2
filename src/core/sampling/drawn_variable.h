#pragma once
#include "model/equilibrium.h"
#include "sampling/sampler_spec.h"

namespace granuscope {
/// The split H_R of a bead whose number of [0, 1) is `uniform`: the variable that the law draws (DrawnVariable) is
/// uniform on what the interval leaves of it. Other variables than the force use half of the numbers for each of the
/// two contacts.
double split_at(DrawnVariable drawn, Outgoing out, double H, Interval interval, double uniform);

/// The density of the split of a bead that draws on `interval`, over a bound that it nowhere exceeds: with this
/// probability a split that was drawn uniformly is kept, where a repair must draw it by the bead's own law.
double kept_share(DrawnVariable drawn, Outgoing out, double H, Interval interval, double H_R);

/// Without the mathematical library, whose last bit depends on the instruction set. Radians; |angle| below pi / 2.
double portable_arctangent(double x);
double portable_tangent(double angle);
}  // namespace granuscope
