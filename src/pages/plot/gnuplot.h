#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/font.h"
#include "support/plain_text.h"

namespace granuscope {
/// Of each column of a CSV text (lines of names and units, numbers) its name if it holds no finite number, or nothing:
/// a curve plotted from it would silently be empty.
std::vector<std::string> columns_without_numbers(const std::string& csv);

/// What the file of a figure says of itself, wherever it is taken to: an SVG in <title> and <desc>, a PDF in its
/// document information.
struct FileLabel {
  std::string title;
  std::string command;  ///< that makes it
  std::string program;  ///< provenance_line of the one that made it: version, commit, compiler
};

/// A gnuplot SVG with the label in the place of gnuplot's own. Throws EnvironmentError if there is no such place.
std::string labelled_svg(std::string svg, const FileLabel& label);

/// A PDF of cairo with the label, as an update behind the file. Throws EnvironmentError for a PDF of another build.
std::string labelled_pdf(std::string pdf, const FileLabel& label);

/// The label of an SVG, if it has one.
std::optional<FileLabel> label_of_svg(std::string_view svg);

/// The PDF with every object as it stands and a table of them in plain text. cairo from 1.18 on packs some of them, so
/// that neither a date in them can be taken away without moving all that follows, nor an object be replaced. A PDF that
/// has a plain table, as cairo 1.16 writes it, is returned as it is. Throws EnvironmentError for one that is neither.
std::string with_plain_objects(std::string pdf);

/// Whether gnuplot, or what it plots with, has said of a script that something is wrong. What else stands on standard
/// error is of a wrapper or of the system (modules, for example) and says nothing of the plot.
bool is_complaint(std::string_view standard_error);

/// One plot to be made by gnuplot: a script that reads its data and writes <stem>.svg and <stem>.pdf, all by names
/// relative to the folder it stands in.
struct GnuplotJob {
  std::string stem;
  std::string script;
  std::map<std::string, std::string> data;  ///< file name -> contents (CSV)
  std::string recipe = {};                  ///< of <stem>.json, from which the script can be filled again; "" for none
  std::optional<FileLabel> label = {};      ///< what SVG and PDF say of themselves
  int curves = 0;  ///< plot elements without a title, each with at least one visible mark (titles come by keyentry)
  /// Other than 0: plotted once more, so many inches wide, as <stem>-narrow.svg for phones, panels one above the other;
  /// the script takes `only` and `width`. One SVG cannot be cut into its panels, since the key belongs to all.
  double narrow_inches = 0;
  bool all_columns = true;  ///< each column of the data is plotted, and has to hold a number
};

/// "plot" for "plot-narrow.svg", the plot of a narrow screen.
std::string narrow_svg(const std::string& stem);

/// Throws EnvironmentError, naming the command that installs it, if gnuplot is missing.
void require_gnuplot();

/// Runs the job in a folder of its own below `folder`, checks all that gnuplot's exit status does not tell (silence on
/// stderr, whole files, every curve there), then moves recipe, script, data and labelled plots into `folder`. The same
/// job gives the same bytes. Throws EnvironmentError (gnuplot missing, failing, hanging, or a plot that is not whole);
/// `folder` then holds what it held before.
void plot_with_gnuplot(const GnuplotJob& job, const std::filesystem::path& folder, double timeout_seconds = 60);

/// Whether `folder` holds whole plots of exactly this script and data, of an earlier run.
bool is_drawn(const GnuplotJob& job, const std::filesystem::path& folder);

/// How a figure that was plotted already is to be plotted again.
struct FigureStyle {
  std::string format = "pdf";  ///< pdf, svg, eps, png or tikz
  double width_mm = 0;         ///< 0: as wide as it is
  double dpi = 300;            ///< pixels per inch, of a png
  double font_points = 9;
  std::string font = "DejaVu Sans";  ///< "TeX": that of TeX and its mathematics (tikz, eps)
  std::string language = "en";       ///< of its texts: en, fr or de
  bool trust_script = false;         ///< run the script as it stands, a program that may have come from anywhere
};

/// A figure plotted again.
struct PlottedFigure {
  std::string bytes;            ///< of the file
  std::string title, caption;   ///< in the language asked for, where there are captions in it
  std::string substitute_font;  ///< that fontconfig has in the place of the one asked for; empty if that one is here
  bool other_script = false;    ///< the script that stands there is another one than that which was run
};

/// The ids of the plots in a run's folder of figures, sorted. Throws InputError if there is no such folder.
std::vector<std::string> plots_in(const std::filesystem::path& figures);

/// The figure `id` of a run's folder of figures, plotted again in a folder of its own from the data that stand there
/// and a script filled again from the recipe beside them, with the templates of now. Throws InputError for a figure or
/// recipe that is not there or a style that cannot be, EnvironmentError as plot_with_gnuplot does.
PlottedFigure plot_again(const std::filesystem::path& figures, const std::string& id, const FigureStyle& style);

/// Text with the Greek letters, raised figures and other signs of this program's texts in TeX's own mathematics.
std::string signs_in_tex(std::string text);

/// Text as a gnuplot string that nothing inside can leave: in single quotes, ' doubled, line breaks and other control
/// characters made spaces (and a space put before a leading '). To be set with noenhanced.
std::string gnuplot_string(std::string_view text);

/// Overwrites the creation date that pdfcairo stamps (and SOURCE_DATE_EPOCH does not govern) with spaces. Throws
/// EnvironmentError if there is none.
std::string without_creation_date(std::string pdf);

/// Begins the name of a file of the run before, plotted behind.
inline constexpr std::string_view behind = "behind-";
/// Ends the caption where there are such points.
inline constexpr std::string_view behind_in_words = "Grey: the run before.";

/// Plot elements of a gnuplot SVG that hold at least one visible mark (line, area, point). Those with a title do not
/// count, because their sample in the key is a mark whatever became of the curve: a script names its curves by
/// keyentry. A title that names the data ("data FILE COLUMNS STYLE X0 X1 Y0 Y1 | X | Y", ends and names of the axes) is
/// for the page, which reads the points' numbers by it, and stands in no key. The run before does not count.
int count_visible_curves(std::string_view svg);

/// A text of a gnuplot SVG and the rectangle that it fills, which may be turned; pixels.
struct SvgText {
  std::string text;
  Corner middle;
  double half_width = 0, half_height = 0;
  Corner along{1, 0};  ///< unit vector in which it is read

  std::array<Corner, 4> corners() const;
};

/// All texts of a gnuplot SVG, by the metrics of a font file, DejaVu Sans if none is named; a sign that stands lower or
/// higher counts as wide as another.
std::vector<SvgText> texts_of_svg(std::string_view svg, const std::string& font_file = "");

/// The first text that an edge of the SVG cuts by more than two pixels; empty if there is none.
std::string clipped_text(std::string_view svg, const std::string& font_file = "");

/// A hidden folder for work in progress, removed with everything in it when it goes out of scope
/// (and by remove_leftovers, should the program be killed before).
class ScratchFolder {
 public:
  /// Makes a folder of its own in `parent` (and the parents), with `name` in its name. Throws EnvironmentError.
  ScratchFolder(const std::filesystem::path& parent, const std::string& name);
  /// In the folder for temporary files. Throws EnvironmentError if TMPDIR names none.
  explicit ScratchFolder(const std::string& name);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace granuscope
