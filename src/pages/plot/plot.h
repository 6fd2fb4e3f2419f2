#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"

// A figure as data: panels with axes and curves, a key above them, and the files they are read from. One script,
// templates/plot/figure.gp.mustache, is filled from it.
namespace granuscope {
/// Most plots are as wide as the text of the printed report, 170 mm, with text of 9 pt.
inline constexpr double plot_width_inches = 6.69;
/// Of a plot of one panel, with text of 8 pt: two stand side by side.
inline constexpr double half_plot_width_inches = 3.228;

/// How a curve, or its sample in the key, is shown.
struct Style {
  std::string with = "lines";    ///< gnuplot's: points, lines, linespoints, yerrorbars, xyerrorlines, ...
  std::string colour = "black";  ///< of templates/palette.txt
  double width = 0;              ///< of lines, 0 for gnuplot's own
  int dash = 0, marker = 0;      ///< gnuplot's dashtype and pointtype, 0 for its own
  double size = 0;               ///< of points, 0 for none
};

/// Colour and marker of a series; what is asked of it are styles in them.
struct Ink {
  std::string colour = "black";
  int marker = 7;

  Style line(double width, int dash = 0) const { return {"lines", colour, width, dash, 0, 0}; }
  Style points(double size, double width = 0) const { return {"points", colour, width, 0, marker, size}; }
  Style joined(double width, double size, int dash = 0) const {
    return {"linespoints", colour, width, dash, marker, size};
  }
  Style bars(double width, double size) const { return {"yerrorbars", colour, width, 0, marker, size}; }
  Style both_bars(double width, double size) const { return {"xyerrorbars", colour, width, 0, marker, size}; }
  Style joined_bars(double width, double size, int dash = 0) const {
    return {"yerrorlines", colour, width, dash, marker, size};
  }
};

/// Of curve number `index` in a figure with one curve for each kind of thing, such as laws. Colours repeat after six,
/// markers after seven. None has the colour in which another reading stands beside this run's.
Ink ink_of_series(std::size_t index);

/// With one curve for each value of something, such as mu: the same markers, and five shades of the colour of this run,
/// from light to dark.
Ink ink_of_value(std::size_t index);

/// What is plotted: columns of a file, or a function of $1 from one x to another.
struct Curve {
  std::string file, columns;  ///< "1:2:3", gnuplot's `using`
  std::string function;       ///< "exp(0.1) * $1**2"; empty for a file
  double from = 0, to = 0;
  Style style;
  std::string series = {};  ///< what its points are told to be; else what the key calls them
};

/// A text in a panel, at shares of its width and height.
struct PanelText {
  std::string text;
  double x = 0, y = 0;
  std::string align = "left";
  std::string colour = "black";
};

/// A straight line in a panel; y in shares of its height, x likewise ("graph") or on its axis ("first").
struct PanelArrow {
  double x = 0, y = 0, to_x = 0, to_y = 0;
  std::string x_in = "graph";
  bool head = false;
  Style style;
};

/// Places in x are shares of a plot 6.69 in wide, in y inches from the top or bottom of the row.
struct Panel {
  Axis x, y;
  double left = 0.105, right = 0.985;
  double name = 0.014;      ///< where the name of the vertical axis stands
  bool name_above = false;  ///< it stands above the axis
  double top = 0.08, bottom = 0.48;
  std::vector<Curve> curves;
  std::vector<PanelText> texts;
  std::vector<PanelArrow> arrows;
  Range band;  ///< of x that is shaded

  void add(const std::string& file, const std::string& columns, const Style& style, const std::string& series = "") {
    curves.push_back({file, columns, "", 0, 0, style, series});
  }
  void add_function(const std::string& function, double from, double to, const Style& style) {
    curves.push_back({"", "", function, from, to, style});
  }
  /// A horizontal line across the panel, whose axis of x is known, behind its curves.
  void add_level(double y_value, const Style& style);
};

/// The left and the right one of two panels side by side.
Panel left_panel();
Panel right_panel();

struct KeyEntry {
  std::string title;
  Style style;
};

/// What stands above the panels.
struct PlotKey {
  double inches = 0;  ///< its height, of `lines` lines
  int lines = 1;
  bool horizontal = false;  ///< filled line by line
  bool centred = false;     ///< in its height
  double sample = 2.5;      ///< length of a sample, in letters
  std::vector<KeyEntry> entries;
};

struct Plot {
  std::string id;     ///< "response-profiles": stem of all its files
  double height = 3;  ///< inches, with text of 9 pt
  bool half_width = false;
  PlotKey key;
  std::vector<Panel> panels;
  std::map<std::string, std::string> data;  ///< file name -> CSV
  int other_curves = 0;                     ///< elements that a script of its own plots beside those of the panels
  Json own = Json::object();                ///< more for such a script

  /// Adds the file ID-NAME.csv, or ID.csv for "", and returns its name.
  std::string add_data(const std::string& name, const CsvTable& table);
  void add_key(const std::string& title, const Style& style) { key.entries.push_back({title, style}); }
};

/// An axis for Plot::own, where a script finds low, high, label and marks of it.
Json axis_json(const Axis& axis);

/// All that a script and its captions are filled from, to be filled again from other templates.
struct FigureRecipe {  // NOLINT(bugprone-exception-escape): ordered_json has a move that may throw
  std::string id;
  Json plot;  ///< what the script is filled from
  Wording wording;
  std::string title, caption;  ///< as the wording was when it was made
};

/// The script, from the templates of now: templates/X.gp.mustache for captions X.captions if there is one, else
/// plot/figure.gp.mustache. `catalogue`: of its language.
std::string fill_script(const FigureRecipe& recipe, std::string_view catalogue = "");

/// The recipe as JSON, as it stands beside the script.
std::string recipe_json(const FigureRecipe& recipe);

/// A recipe that recipe_json wrote. Throws InputError, naming `source`, for what is none, or holds a text that gnuplot
/// could run as a command: whoever made the file need not be trusted.
FigureRecipe read_recipe(const std::string& json, const std::string& source);

/// Plots it into `run_folder`/figures, and returns the figure with its captions. Where gnuplot fails the figure says
/// why and has no files, or those that an earlier run plotted from the same script and data: the other figures, and the
/// numbers, are not to be lost for it.
Figure plot_figure(const Plot& plot, const Wording& wording, const std::filesystem::path& run_folder);

}  // namespace granuscope
