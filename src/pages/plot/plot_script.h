#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "sampling/sampler_spec.h"

namespace granuscope {
/// Most plots are as wide as the text of the printed report, 170 mm, with text of 9 pt.
inline constexpr double plot_width_inches = 6.69;
/// Two of these stand side by side there, 82 mm each, with text of 8 pt.
inline constexpr double half_plot_width_inches = 3.228;

/// A plot as wide as the text is made again this wide, for phones: two panels stand one above the other there.
inline constexpr double narrow_plot_width_inches = 0.5 * plot_width_inches;

/// A part of a script that several figures share, with what fills it.
struct ScriptPart {
  std::string script;  ///< template, as of a PlotPlan
  TemplateVariables variables;
};

/// A figure as it is being made: its id, the size of its plot, and the data files it reads.
struct PlotPlan {
  std::string id;      ///< "response-profiles": stem of all its files
  std::string script;  ///< "plot/response_profiles": script template below templates/, without .gp.mustache
  double height = 3;   ///< inches, with text of 9 pt
  bool half_width = false;
  int curves = 0;                           ///< elements the script plots
  std::map<std::string, std::string> data;  ///< file name -> CSV
  std::vector<ScriptPart> parts;

  /// The text of a variable in whose place the part will stand.
  std::string add_part(ScriptPart part);
};

/// All that a script and its captions are filled from, to be filled again from other templates.
struct FigureRecipe {
  std::string id, script;
  double height = 3;
  bool half_width = false;
  TemplateVariables variables;
  std::vector<ScriptPart> parts;
  Wording wording;
  std::string title, caption;  ///< as the wording was when it was made
  TemplateVariables colours;   ///< of the palette with which it was made
};

/// The script, from the templates of now.
std::string fill_script(const FigureRecipe& recipe);

/// The recipe as JSON, as it stands beside the script.
std::string recipe_json(const FigureRecipe& recipe);

/// A recipe that recipe_json wrote, its colours those of the palette of now. Throws InputError, naming `source`, for
/// what is none, names a template that is not there, or holds a variable that gnuplot could run as a command: whoever
/// made the file need not be trusted.
FigureRecipe read_recipe(const std::string& json, const std::string& source);

/// Fills the script template (common set-up, terminals and colours are given; `variables` has the rest), plots it into
/// `run_folder`/figures, and returns the figure with its captions. Where gnuplot fails the figure says why and has
/// no files, or those that an earlier run plotted from the same script and data: the other figures, and the numbers,
/// are not to be lost for it.
Figure plot_figure(const PlotPlan& plan, const TemplateVariables& variables, const Wording& wording,
                   const std::filesystem::path& run_folder);

/// How many curves the key names, and how many letters the longest name has: the room that a key needs.
struct KeySize {
  int entries = 0, letters = 0;
};
KeySize size_of_key(const std::string& script);

/// The categorical colours of templates/palette.txt (Okabe and Ito) by name, as "#rrggbb": black, orange, sky_blue,
/// bluish_green, yellow, blue, vermilion, reddish_purple, and frame for decorations. Throws std::logic_error if the
/// palette lacks one.
TemplateVariables plot_colours();

/// Colour and marker of curve number `index` in a figure with one curve for each friction coefficient, in gnuplot's
/// words: "pointtype 7 linecolor rgb '#0072b2'". Colours repeat after six, markers after seven.
std::string series_style(std::size_t index);

/// The script with its texts in another language: in every quoted text that is no file name, the phrases of a catalogue
/// (templates/plot/labels.txt has its form) and the decimal point are replaced; a longer phrase comes before one that
/// it holds. Throws InputError for a line of the catalogue that is none.
std::string in_language(const std::string& script, std::string_view catalogue);

/// Any text with the phrases of a catalogue replaced, as whole words; its decimal points stay.
std::string in_terms(const std::string& text, std::string_view catalogue);

/// The catalogue by which texts about friction speak of what else an experiment varies; empty for friction itself.
std::string terms_of(const ScanParameter& parameter);

/// The quoted texts of a script that are neither file names nor formats, as they stand.
std::vector<std::string> texts_of_script(std::string_view script);

/// The catalogue of a language that is built in: "en" (nothing changes), "fr", "de". Throws InputError for another.
std::string_view catalogue_of(const std::string& language);

}  // namespace granuscope
