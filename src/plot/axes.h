#pragma once
#include <string>
#include <vector>

namespace granuscope {

/// The ends of an axis that shows every number added to it.
struct Range {
  double low = 0;
  double high = 0;
  bool empty = true;

  void add(double number);  ///< numbers that are not finite are ignored
  double size() const { return high - low; }
};

/// Gnuplot's list of labelled tick marks within `range`, at most `most` of them, at whole multiples of 1, 2 or 5 times
/// a power of ten, all with the same number of decimals and a typographic minus.
std::string linear_ticks(const Range& range, int most);

/// Three marks, one at 0 and one at either side, for a panel too low for more.
std::string three_ticks(double reach);

/// By how much of the plot's width the longest label of vertical axes exceeds the room that the scripts leave for it
/// between an axis and its name (six letters); 0 where it does not.
double room_for_labels(const std::vector<std::string>& tick_lists);

/// Gnuplot's list of tick marks for a logarithmic axis: labels at 1, 2, 5 of each decade, or at the decades alone if
/// two of them lie on it, as powers of ten where the axis reaches below 0.001 or to 100 000; small unlabelled marks at
/// the other whole multiples. An axis too short for two labels of this
/// kind gets those of linear_ticks.
std::string log_ticks(const Range& range);

/// The same marks without their labels, for a panel whose labels stand below another.
std::string without_labels(const std::string& ticks);

/// A logarithmic axis with a margin of `factor` beyond both ends.
Range widened_by_factor(const Range& range, double factor);

}  // namespace granuscope
