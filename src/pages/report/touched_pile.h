#pragma once
#include <string>

#include "model/pile.h"

namespace granuscope {
/// A pile as JSON for the page, which paints it in layers that can be moved and enlarged (templates/report.js): forces
/// and mobilised friction of the contacts to the lower left and right of each bead, its weight, and how an overload
/// changes that, all in thousandths, layer by layer down to `layers`. The piles of the overload may be null. Empty
/// where there are more beads than a page has room for.
std::string touched_pile(const Pile& pile, const Pile* overloaded, const Pile* uniform, int layers);
}  // namespace granuscope
