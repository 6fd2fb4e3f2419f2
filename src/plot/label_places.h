#pragma once
#include <string>
#include <vector>

#include "plot/axes.h"

namespace granuscope {

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
  std::vector<Range> notes_y;    ///< horizontal strips taken by the panel's own text, from its left edge to its middle
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

/// The gnuplot commands that put the names at those places, tags from 100 on: the text in the small font of insets,
/// its line in the frame's colour.
std::string label_commands(const std::vector<NamedPoint>& points, const LabelledPanel& panel);

}  // namespace granuscope
