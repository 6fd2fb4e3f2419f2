#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "ensemble/ensemble_spec.h"

namespace granuscope {
/// Members stay in the order in which they were written.
using Json = nlohmann::ordered_json;

/// One finished figure with its files; paths are relative to the run's folder.
struct Figure {
  std::string id;  ///< "response-profiles", also the stem of its files
  std::string title;
  std::string caption;                      ///< at most 60 words, the finding first; plain text, UTF-8
  std::string details = {};                 ///< how it is made and what it leaves out, for those who want to know
  std::string alternative;                  ///< what a reader who cannot see it must know
  std::string paper_says;                   ///< what the paper reports about it, paraphrased
  std::filesystem::path screen;             ///< SVG, or PNG for a rendered picture
  std::filesystem::path narrow = {};        ///< for a phone, panels one above the other; empty where none is needed
  std::filesystem::path print;              ///< PDF, or PNG for a rendered picture
  std::filesystem::path script;             ///< gnuplot script, empty for a rendered picture
  std::filesystem::path recipe;             ///< JSON that fills the script again, empty for a rendered picture
  std::vector<std::filesystem::path> data;  ///< CSV
  std::string touched = {};                 ///< JSON of a pile to be looked at in the page (report/touched_pile.h)
  std::string redraw;                       ///< the command that makes it again
  std::string failure = {};                 ///< why it could not be made in this run; empty if it was

  /// Whether there is an image: of this run, or of an earlier one from the same script and data.
  bool is_there() const { return !screen.empty(); }
};

/// Makes a figure in the run's folder. Throws InputError if there is nothing to show.
using FigurePlot = std::function<Figure(const std::filesystem::path& run_folder)>;

/// "multiplexed, ε = 0.25, opposite, runs of 2"; of another estimator its name.
std::string in_words(const ResponseSpec& response);

/// What fills the places of a template, by name. An empty text also means "not there" to a section.
using TemplateVariables = std::map<std::string, std::string>;

/// Fills a template of a script or a caption (support/templates.h). Nothing is escaped: scripts and captions are
/// not HTML. Throws std::logic_error for a name without a text, also in a section that is not written, and for a text
/// that no place asks for: a place that silently stays empty would be a wrong figure.
std::string fill_template(std::string_view text, const TemplateVariables& variables);

/// The template of a figure's captions and what fills it.
struct Wording {
  std::string captions;  ///< "plot/response_profiles.captions", below templates/
  TemplateVariables variables;
  std::string terms = {};  ///< terms_of(what varies), in which all but what the paper says is put
};

/// Fills `figure`'s title, caption, details, alternative and paper_says from its wording: headings in square
/// brackets, each followed by its text, which becomes one paragraph. Throws std::logic_error if one is missing. Numbers
/// have the decimal sign of the catalogue of phrases; without one, of plot/labels.txt.
void set_captions(Figure& figure, const Wording& wording, std::string_view catalogue = {});

/// "a", "a and b", "a, b and c".
std::string enumeration(const std::vector<std::string>& items);

/// What a figure leaves out, and why.
struct LeftOut {
  std::string what, why;
};

/// "a and b (why), c (another why)": those with the same reason together, in the order of the first of them. What
/// begins with "μ = " in one group says so once: "μ = 0.1 and 0.2 (why)".
std::string with_reasons(const std::vector<LeftOut>& items);

/// A count in words up to twelve, as digits beyond: "two", "14".
std::string count_in_words(std::size_t count);

/// A number as a caption shows it: at most `digits` significant digits, no trailing zeros, typographic minus.
std::string caption_number(double value, int digits = 4);

}  // namespace granuscope
