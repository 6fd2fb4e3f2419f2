#pragma once
#include <cstddef>
#include <string>

namespace granuscope {

/// Colour and marker of curve number `index` in a figure with one curve for each friction coefficient, in gnuplot's
/// words: "pointtype 7 linecolor rgb '#0072b2'". Colours repeat after six, markers after seven.
std::string series_style(std::size_t index);

}  // namespace granuscope
