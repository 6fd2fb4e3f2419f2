#pragma once
#include <type_traits>

#include "model/friction_cone.h"
#include "model/lattice.h"
#include "model/scalar_arithmetic.h"

namespace granuscope {

namespace scalar {
#include "model/equilibrium_formulas.inc"
}  // namespace scalar

using Interval = scalar::IntervalOf<double>;
using Incoming = scalar::IncomingOf<double>;
using Outgoing = scalar::OutgoingOf<double>;
using scalar::balance;
using scalar::draw_bead;
using scalar::intersection;
using scalar::point_at;
using scalar::solvable_band;
using scalar::split_interval;
using scalar::unsolvable;

}  // namespace granuscope
