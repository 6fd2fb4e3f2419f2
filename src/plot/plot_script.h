#pragma once
#include <filesystem>
#include <string>

#include "plot/figure.h"
#include "plot/gnuplot.h"
#include "plot/template_variables.h"

namespace granuscope {

/// Every plot is as wide as the text of the printed report, 170 mm, so that its 9 pt stay 9 pt there.
inline constexpr double plot_width_inches = 6.69;

/// A figure as it is being made: its id, the size of its plot, and the data files it reads.
struct PlotPlan {
  std::string id;      ///< "response-profiles": stem of all its files
  std::string script;  ///< "plot/response_profiles": script template below templates/, without .gp.mustache
  double height = 3;   ///< inches; every plot is as wide as the text of the printed report
  int curves = 0;      ///< elements the script plots
  std::map<std::string, std::string> data;  ///< file name -> CSV
};

/// Fills the script template (common set-up, terminals and colours are given; `variables` has the rest), plots it into
/// `run_folder`/figures, and returns the figure without its captions. Where gnuplot fails the figure says why and has
/// no files, or those that an earlier run plotted from the same script and data: the other figures, and the numbers,
/// are not to be lost for it.
Figure plot_figure(const PlotPlan& plan, const TemplateVariables& variables, const std::filesystem::path& run_folder);

/// How many curves the key names, and how many letters the longest name has: the room that a key needs.
struct KeySize {
  int entries = 0, letters = 0;
};
KeySize size_of_key(const std::string& script);

/// A part of a script that several figures share, with the colours it names: templates/<name>.gp.mustache.
std::string fill_script_part(const std::string& name, TemplateVariables variables);

}  // namespace granuscope
