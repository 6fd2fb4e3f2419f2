#pragma once
#include <array>
#include <functional>
#include <vector>

#include "analysis/results.h"

namespace granuscope {

/// The result nearest in mu among those that `usable` accepts (the lower mu of two equally near), or nullptr.
const Transport* nearest_result(const std::vector<Transport>& results, double mu,
                                const std::function<bool(const Transport&)>& usable);

/// The same analysis for the figures against mu: a c or D too uncertain to be a point becomes unknown, with that as the
/// reason, so that one error bar does not squeeze all other points together. One that was unknown before gets a reason
/// that points to the table of c and D, which tells it at length: each of these figures would tell it again.
Analysis without_imprecise_points(const Analysis& analysis);

/// Whether mu lies in the closed window (with room for the rounding of decimal fractions).
bool in_window(double mu, const std::array<double, 2>& window);

}  // namespace granuscope
