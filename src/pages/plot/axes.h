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
  /// Both ends of an error bar.
  void add(double number, double error) {
    add(number - error);
    add(number + error);
  }
  double size() const { return high - low; }
};

inline Range range_of(double one, double other) {
  Range range;
  range.add(one);
  range.add(other);
  return range;
}

/// A mark on an axis. An empty label: none.
struct Tick {
  std::string label;
  double at = 0;
  bool minor = false;
};

/// An axis of a panel with its marks.
struct Axis {
  std::string label;
  double low = 0, high = 1;
  bool log = false;
  std::vector<Tick> ticks;
  bool silent = false;  ///< its name is told of a point, but does not stand beside it
};

/// An axis of `shown` with at most `most` marks, which lie within `marked` if that is given.
Axis linear_axis(std::string label, const Range& shown, int most);
Axis linear_axis(std::string label, const Range& shown, int most, const Range& marked);
Axis log_axis(std::string label, const Range& shown);

/// The same axis without words, above one that has them.
Axis without_words(Axis axis);

/// A range with so many shares of its size more at both ends.
Range widened(const Range& range, double share);

/// Labelled tick marks within `range`, at most `most` of them, at whole multiples of 1, 2 or 5 times a power of ten,
/// all with the same number of decimals and a typographic minus.
std::vector<Tick> linear_marks(const Range& range, int most);

/// Tick marks of a logarithmic axis: labels at 1, 2, 5 of each decade, or at the decades alone if two of them lie on
/// it, as powers of ten where the axis reaches below 0.001 or to 100 000; small unlabelled marks at the other whole
/// multiples. An axis too short for two labels of this kind gets those of linear_marks.
std::vector<Tick> log_marks(const Range& range);

/// Three marks, one at 0 and one at either side, for a panel too low for more.
std::vector<Tick> three_marks(double reach);

/// By how much of the plot's width the longest label of a vertical axis exceeds the room between the axis and the
/// middle of its name, which is `from_name`; 0 where it does not.
double room_for_labels(const std::vector<Tick>& ticks, double from_name);

/// A logarithmic axis with a margin of `factor` beyond both ends.
Range widened_by_factor(const Range& range, double factor);

/// A place in a panel, as shares of its width and height from its lower left corner.
struct PanelPlace {
  double x = 0, y = 0;
};

/// A measured point that wants its name beside it.
struct NamedPoint {
  PanelPlace at;
  Range bar_x, bar_y;  ///< reach of its error bars, as shares of the panel
  std::string name;
};

/// A straight piece of a curve that names should not stand on.
struct PanelLine {
  PanelPlace from, to;
};

/// Size of a panel and what must stay free in it.
struct LabelledPanel {
  double width = 1, height = 1;  ///< inches
  std::vector<PanelLine> lines;  ///< of its curves
  std::vector<PanelLine> taken;  ///< from one corner to the other of rectangles that its own texts fill

  /// A text that begins at x, or ends there if x lies in the right half, with its middle at height y.
  void add_text(const std::string& text, double x, double y);
};

/// Where a name stands.
struct LabelPlace {
  PanelPlace left;         ///< the middle of its left edge
  PanelPlace touch;        ///< where a thin line from the point meets it
  bool with_line = false;  ///< it stands so far from its point that a line has to join them
};

/// A place for each point's name, in the order of `points`: inside the panel, off the points, bars, curves and other
/// names as far as there is room, and as near to its point as that allows. The same input gives the same places.
std::vector<LabelPlace> place_labels(const std::vector<NamedPoint>& points, const LabelledPanel& panel);

/// A right triangle that shows a slope, and the end of its text from which that is aligned.
struct SlopeTriangle {
  PanelPlace low, high, corner, text;
  std::string align;
};

/// A triangle of `slope` (shares of the height over shares of the width) as near to the lines as leaves air around it
/// and its text; where there is no such place, where there is most.
SlopeTriangle place_slope_triangle(double slope, const std::string& text, const LabelledPanel& panel);

}  // namespace granuscope
