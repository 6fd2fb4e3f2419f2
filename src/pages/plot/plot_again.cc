#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "render/font.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"
#include "support/templates.h"

namespace granuscope {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 5> ends_of_formats = {
    {{"pdf", "%%EOF"}, {"svg", "</svg>"}, {"eps", "%%EOF"}, {"png", "IEND"}, {"tikz", "\\end{tikzpicture}"}}};

/// Of a figure whose texts TeX sets.
constexpr std::string_view font_of_tex = "TeX";

constexpr double least_width_mm = 60, most_width_mm = 1000, least_points = 4, most_points = 40;
constexpr double least_dpi_of_plots = 50, most_dpi_of_plots = 1200, most_pixels = 30'000;  // Cairo paints 32 767

void require_possible(const FigureStyle& style) {
  const auto known = [&style](const auto& format) { return format.first == style.format; };
  if (std::ranges::none_of(ends_of_formats, known)) {
    throw InputError("there is no format {} for a figure; choose pdf, svg, eps, png or tikz", style.format);
  }
  if (style.width_mm != 0 && !(style.width_mm >= least_width_mm && style.width_mm <= most_width_mm)) {
    throw InputError("a figure {:g} mm wide has no room for its text, or none on any page; give {:g} to {:g}",
                     style.width_mm, least_width_mm, most_width_mm);
  }
  if (!(style.font_points >= least_points && style.font_points <= most_points)) {
    throw InputError("text of {:g} pt cannot be read or fills the figure; give {:g} to {:g}", style.font_points,
                     least_points, most_points);
  }
  const FigureStyle usual;
  const double inches = (style.width_mm == 0 ? 170 : style.width_mm) / 25.4;
  const double most_dpi_here = std::min(most_dpi_of_plots, std::floor(most_pixels / inches));
  if (style.dpi != usual.dpi && style.format != "png")
    throw InputError("{} has no pixels, and is sharp at any size; give --dpi with --format png only", style.format);
  if (!(style.dpi >= least_dpi_of_plots && style.dpi <= most_dpi_here)) {
    throw InputError("a figure {:.3g} mm wide cannot be painted at {:g} pixels per inch; choose {:g} to {:g}",
                     inches * 25.4, style.dpi, least_dpi_of_plots, most_dpi_here);
  }
}

}  // namespace

std::string signs_in_tex(std::string text) {
  std::vector<std::pair<std::string, std::string>> signs = {{"–", "--"}, {"’", "'"}};
  // Each sign before what the mathematics of TeX calls it.
  std::istringstream mathematics(
      "α \\alpha β \\beta γ \\gamma δ \\delta Δ \\Delta ε \\varepsilon μ \\mu σ \\sigma τ \\tau χ \\chi "
      "θ \\theta φ \\varphi λ \\lambda ₀ _0 ₁ _1 ₂ _2 ₃ _3 ₄ _4 ₚ _p ² ^2 ³ ^3 ⁰ ^0 ¹ ^1 ⁴ ^4 ⁵ ^5 ⁶ ^6 "
      "⁷ ^7 ⁸ ^8 ⁹ ^9 ⁻ ^- | | ½ {}^1\\!/_2 ≈ \\approx − - ± \\pm ≤ \\le ≥ \\ge × \\times √ \\surd "
      "° ^\\circ ∝ \\propto ⟨ \\langle ⟩ \\rangle κ \\kappa ᵅ ^\\alpha ᵝ ^\\beta ᵞ ^\\gamma ᵏ ^k ᵢ _i "
      "η \\eta ν \\nu ∂ \\partial ′ ^\\prime");
  for (std::string sign, tex; mathematics >> sign >> tex;)
    signs.emplace_back(sign, fmt::format("\\ensuremath{{{}}}", tex));
  for (const auto& [sign, tex] : signs) {
    for (std::size_t at = text.find(sign); at != std::string::npos; at = text.find(sign, at + tex.size())) {
      text.replace(at, sign.size(), tex);
    }
  }
  return text;
}

namespace {

constexpr const char* italic = "{/:Italic ";

/// What stands in the scripts as Unicode or as gnuplot's markup, in TeX's own mathematics.
std::string script_in_tex(std::string text) {
  // gnuplot's own marks of what stands lower or higher: a sign or a group in braces.
  for (std::size_t at = text.find_first_of("_^"); at != std::string::npos; at = text.find_first_of("_^", at)) {
    const bool group = at + 1 < text.size() && text[at + 1] == '{';
    std::size_t end = group ? text.find('}', at) : at + 2;
    if (end == std::string::npos) break;
    while (!group && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) ++end;  // of one sign
    const std::string inside = group ? text.substr(at + 2, end - at - 2) : text.substr(at + 1, end - at - 1);
    const std::string tex = group ? fmt::format("\\ensuremath{{{}\\mathrm{{{}}}}}", text[at], inside)
                                  : fmt::format("\\ensuremath{{{}{}}}", text[at], inside);
    text.replace(at, (group ? end + 1 : end) - at, tex);
    at += tex.size();
  }
  for (std::size_t at = text.find(italic); at != std::string::npos; at = text.find(italic, at)) {
    text.replace(at, std::string_view(italic).size(), "\\textit{");
  }
  return signs_in_tex(std::move(text));
}

/// gnuplot's TikZ writes a text into the last pair of braces of a line that begins with \node, as it stands; and the
/// moment into a comment.
std::string with_tex_texts(const std::string& tikz) {
  std::string result;
  for (std::size_t from = 0; from < tikz.size();) {
    const std::size_t end = std::min(tikz.find('\n', from), tikz.size() - 1) + 1;
    std::string line = tikz.substr(from, end - from);
    from = end;
    const std::size_t at = line.find("] at (");
    const std::size_t open = line.find('{', line.find(')', at));
    if (line.starts_with("\\node") && at != std::string::npos && open != std::string::npos) {
      std::string text = line.substr(open);
      for (std::size_t i = text.find('%'); i != std::string::npos; i = text.find('%', i + 2)) text.insert(i, "\\");
      line = line.substr(0, open) + script_in_tex(text);
    }
    if (!line.starts_with("%% ") || line.starts_with("%% generated")) result += line;
  }
  return result;
}

/// The command that plots it again from the folder of its run.
std::string command_of(const std::string& id, const FigureStyle& style) {
  return fmt::format("granuscope figure OUT {} --format {}{}{} --font-size {} --font {}{}", id, style.format,
                     style.width_mm == 0 ? "" : fmt::format(" --width {}mm", style.width_mm),
                     style.dpi == FigureStyle().dpi ? "" : fmt::format(" --dpi {}", style.dpi), style.font_points,
                     gnuplot_string(style.font), style.language == "en" ? "" : " --language " + style.language);
}

/// Says by which command it was plotted, where gnuplot leaves no room for a label, and how wide a PNG is on paper.
std::string marked(std::string bytes, const std::string& id, const FigureStyle& style) {
  const std::string mark = command_of(id, style);
  if (style.format == "eps") bytes.insert(bytes.find('\n') + 1, "% " + mark + "\n");
  if (style.format == "tikz") {
    bytes.insert(
        0, fmt::format("% {}; needs \\usepackage{{gnuplot-lua-tikz}}, which comes with gnuplot, not with TeX\n", mark));
  }
  if (style.format == "png") {  // pieces behind the header, which is the first 33 bytes of every PNG
    const auto number = [](uLong value) {
      std::string text;
      for (int shift = 24; shift >= 0; shift -= 8) text += static_cast<char>((value >> shift) & 0xff);
      return text;
    };
    constexpr std::size_t header = 33, kind = 4;
    const auto pixels_per_metre = static_cast<uLong>(std::lround(style.dpi / 0.0254));
    for (const std::string& text : {std::string("tEXtSoftware") + '\0' + mark,
                                    "pHYs" + number(pixels_per_metre) + number(pixels_per_metre) + '\1'}) {
      const uLong sum = crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size()));
      if (bytes.size() > header) bytes.insert(header, number(text.size() - kind) + text + number(sum));
    }
  }
  return bytes;
}

std::string without_moment(std::string eps) {
  const std::size_t at = eps.find("%%CreationDate:");
  return at == std::string::npos ? eps : eps.erase(at, eps.find('\n', at) + 1 - at);
}

/// From what the run filled the script. Old versions left none.
std::optional<FigureRecipe> recipe_of_run(const fs::path& file, const std::string& id, bool trust_script) {
  if (trust_script && !templates_folder().empty()) {
    throw InputError("--trust-script runs the script that stands there, which no templates change; leave one out");
  }
  if (!file_exists(file)) {
    if (trust_script) return std::nullopt;
    throw InputError(
        "{}: there is no such file, from which the script of the figure could be filled again, and a script that "
        "stands in a folder can run any command; run the experiment again with this version, or give --trust-script if "
        "you trust {}.gp",
        file.string(), id);
  }
  FigureRecipe recipe = read_recipe(read_file(file), file.string());
  if (recipe.id == id) return recipe;
  throw InputError("{}: this is the recipe of another figure, {}; run the experiment again", file.string(),
                   single_line(recipe.id));
}

/// What `fill` makes of a recipe; templates that lack one of its variables, or ask for more, are no mistake of this
/// program but those of another version.
template <typename Fill>
auto filled(const fs::path& file, const Fill& fill) {
  try {
    return fill();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {  // of the templates, or of fields that are none
    throw InputError("{}: this recipe does not fit the templates ({}); run the experiment again with this version",
                     file.string(), single_line(error.what()));
  }
}

/// What the plot of the run says of itself.
std::optional<FileLabel> label_of_run(const fs::path& svg) {
  return file_exists(svg) ? label_of_svg(read_file(svg)) : std::nullopt;
}

}  // namespace

std::vector<std::string> plots_in(const fs::path& figures) {
  std::vector<std::string> known;
  require_visible(figures);
  if (!folder_exists(figures)) {
    if (path_exists(figures.parent_path() / "manifest.json")) return known;  // a run of which nothing was plotted
    throw InputError("there is no folder {}, so no figure of a run; name the folder that `granuscope run` wrote",
                     figures.string());
  }
  for (const fs::path& entry : entries_of(figures)) {
    if (entry.extension() == ".gp") known.push_back(entry.stem().string());
  }
  std::ranges::sort(known);
  return known;
}

namespace {

/// The figure as an EPS that TeX sets, with its own fonts and mathematics. dvips finds the edges of letters and rules,
/// not those of what is drawn: hair-thin white rules stand in the corners.
std::string eps_by_tex(const std::string& tikz, const std::string& id, double points) {
  const ScratchFolder scratch(id);
  write_file(scratch.path() / "figure.tikz", tikz);
  write_file(scratch.path() / "figure.tex",
             fmt::format("\\documentclass{{article}}\n\\usepackage{{fix-cm}}\n\\usepackage{{tikz,gnuplot-lua-tikz}}\n"
                         "\\pagestyle{{empty}}\n\\parindent=0pt\n\\hoffset=-1in\n\\voffset=-1in\n\\textwidth="
                         "1200mm\n\\textheight=1200mm\n"
                         "\\begin{{document}}\n\\fontsize{{{0}}}{{{1}}}\\selectfont\n"
                         "\\setbox0=\\hbox{{\\input{{figure.tikz}}}}\n\\def\\hair{{\\hbox{{\\color{{white}}\\vrule "
                         "width 0.01pt height 0.01pt depth 0pt}}}}\n"
                         "\\hbox{{\\rlap{{\\lower\\dp0\\hair}}\\rlap{{\\raise\\ht0\\hair}}\\rlap{{"
                         "\\kern\\wd0\\raise\\ht0\\hair}}\\copy0}}\n\\end{{document}}\n",
                         points, 1.2 * points));
  const auto run = [&](const std::vector<std::string>& arguments) {
    ProcessSpec process;
    process.arguments = arguments;
    process.working_folder = scratch.path();
    // TeX and dvips write the moment otherwise.
    process.environment = {{"HOME", scratch.path().string()}, {"SOURCE_DATE_EPOCH", "0"}, {"FORCE_SOURCE_DATE", "1"}};
    const ProcessResult result = run_process(process);
    if (!result.timed_out && result.exit_code == 0) return;
    throw EnvironmentError(
        "{} did not set {}: {} {}; the font TeX needs latex with TikZ and dvips (Debian: texlive-latex-base, "
        "texlive-pictures)",
        arguments.front(), id, describe_end(result), single_line(result.standard_error));
  };
  run({"latex", "-no-shell-escape", "-interaction=batchmode", "-halt-on-error", "figure.tex"});
  run({"dvips", "-q", "-E", "-o", "figure.eps", "figure.dvi"});
  return without_moment(read_file(scratch.path() / "figure.eps"));
}

}  // namespace

PlottedFigure plot_again(const fs::path& figures, const std::string& id, const FigureStyle& asked) {
  FigureStyle style = asked;
  require_possible(style);
  if (style.font == font_of_tex && style.format != "tikz") {
    if (style.format != "eps")
      throw InputError("the font TeX is what TeX sets, as tikz or eps, not as {}; choose one of them", style.format);
    FigureStyle tikz = style;
    tikz.format = "tikz";
    PlottedFigure plotted = plot_again(figures, id, tikz);
    plotted.bytes = marked(eps_by_tex(plotted.bytes, id, style.font_points), id, style);
    return plotted;
  }
  require_gnuplot();
  PlottedFigure plotted;
  // gnuplot would take the same font in the place of one that is not here, and say nothing.
  const std::optional<FontMatch> match = match_font(style.font);
  if (style.format != "tikz" && match && match->is_substitute) style.font = plotted.substitute_font = match->family;
  const std::vector<std::string> known = plots_in(figures);
  std::error_code none;
  if (id.find('/') != std::string::npos || !fs::is_regular_file(figures / (id + ".gp"), none)) {
    if (fs::is_regular_file(figures / (id + ".png"), none)) {
      // What a received picture says of itself is no command to be pasted.
      const fs::path pile = figures.parent_path() / "piles" / (id + ".h5");
      const std::string made =
          fs::is_regular_file(pile, none)
              ? fmt::format("granuscope render {} {} --width 86mm", shell_word(pile.string()), shell_word(id + ".png"))
              : "the report says how, below it";
      throw InputError("{} is a picture of beads, which granuscope render makes at any size: {}", id, made);
    }
    throw InputError("{}: there is no plot {}; the plots there are: {}", figures.string(), id,
                     known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", ")));
  }
  const fs::path recipe_file = figures / (id + ".json");
  const std::optional<FigureRecipe> recipe = recipe_of_run(recipe_file, id, style.trust_script);
  const bool other_templates = !templates_folder().empty();
  if (recipe) {
    plotted.title = recipe->title;
    plotted.caption = recipe->caption;
  }
  if (recipe && (other_templates || style.language != "en")) {
    Figure figure;
    filled(recipe_file, [&] {
      const Wording& of_run = recipe->wording;
      const std::string captions = name_in_language(of_run.captions, style.language);
      set_captions(figure, {captions, of_run.variables, of_run.terms},
                   captions == of_run.captions ? "" : catalogue_of(style.language));
    });
    plotted.title = figure.title;
    plotted.caption = figure.caption;
    if (recipe->caption.ends_with(behind_in_words))
      plotted.caption += ' ' + in_terms(std::string(behind_in_words), catalogue_of(style.language));
  }
  const ScratchFolder scratch(id);
  for (const auto& entry : fs::directory_iterator(figures)) {
    const std::string name = entry.path().filename().string();
    if (name == id + ".gp") {
      // Anything may stand there, system() included: only what the recipe gives is run.
      std::string script = read_file(entry.path());
      if (recipe && !style.trust_script) {
        plotted.other_script = !other_templates && filled(recipe_file, [&] { return fill_script(*recipe); }) != script;
        script = filled(recipe_file, [&] { return fill_script(*recipe, catalogue_of(style.language)); });
      }
      write_file(scratch.path() / name, script);
    } else if ((name.starts_with(id) || name.starts_with(std::string(behind) + id)) && name.ends_with(".csv")) {
      write_file(scratch.path() / name, read_file(entry.path()));
    }
  }
  const auto fail = [&](const std::string& what) {
    // What gnuplot says of a line is of the script and its tables, unless this gnuplot lacks a part.
    const bool of_line = is_complaint(what) && what.find(".gp\"") != std::string::npos &&
                         what.find("terminal") == std::string::npos && what.find("font") == std::string::npos;
    if (of_line) {
      throw InputError("{}: gnuplot cannot plot what stands there and in its tables: {}; run the experiment again",
                       (figures / id).string() + (style.trust_script ? ".gp" : ".json"), what);
    }
    throw EnvironmentError(
        "gnuplot did not plot {}: {}; run `granuscope doctor` to see whether gnuplot and the font are there", id, what);
  };
  const auto bytes_as = [&](const std::string& format) {
    std::string settings = fmt::format("only = '{}'; dpi = {}; points = {}; font = {}", format, style.dpi,
                                       style.font_points, gnuplot_string(style.font));
    if (style.width_mm != 0) settings += fmt::format("; width = {}", style.width_mm / 25.4);
    ProcessSpec process;
    process.arguments = {"gnuplot", "-d", "-e", settings, id + ".gp"};
    process.working_folder = scratch.path();
    process.environment = {
        {"LC_ALL", "C.UTF-8"}, {"HOME", scratch.path().string()}, {"XDG_CACHE_HOME", scratch.path().string()}};
    const ProcessResult result = run_process(process);
    const std::string& said = result.standard_error;
    if (result.timed_out || result.exit_code != 0) fail(describe_end(result) + " " + single_line(said));
    if (said.find("too small to hold plot") != std::string::npos ||
        said.find("difficulty fitting plot titles") != std::string::npos) {
      throw InputError("text of {:g} pt has no room in the figure {}; give a smaller --font-size or a greater --width",
                       style.font_points, id);
    }
    if (is_complaint(said)) fail("it complained: " + single_line(said));
    const fs::path file = scratch.path() / (id + "." + format);
    if (!file_exists(file)) fail("there is no file; the script may be of an older version: run it again");
    std::string bytes = read_file(file);
    const auto* const known_end =
        std::ranges::find(ends_of_formats, format, &std::pair<std::string_view, std::string_view>::first);
    if (bytes.rfind(known_end->second) == std::string::npos) fail("the file is cut off");
    return bytes;
  };
  std::string& bytes = plotted.bytes = bytes_as(style.format);
  const FigureStyle usual;
  if (style.format != "tikz" &&
      (style.width_mm != 0 || style.font_points > usual.font_points || style.font != usual.font)) {
    const std::string cut = clipped_text(style.format == "svg" ? bytes : bytes_as("svg"), match ? match->file : "");
    if (!cut.empty()) {
      const double too_large = std::exchange(style.font_points, std::ceil(2 * style.font_points) / 2 - 0.5);
      while (style.font_points > least_points && !clipped_text(bytes_as("svg"), match ? match->file : "").empty())
        style.font_points -= 0.5;
      throw InputError("“{}” of {:g} pt has no room in the figure {}{}; give a greater --width, or --font-size {:g}",
                       cut, too_large, id, style.width_mm == 0 ? "" : fmt::format(", {:g} mm wide", style.width_mm),
                       style.font_points);
    }
  }
  if (style.format == "pdf") bytes = without_creation_date(std::move(bytes));
  if (auto label = label_of_run(figures / (id + ".svg"))) {
    if (recipe) label->title = plotted.title;
    label->command = command_of(id, style);
    if (style.format == "pdf") bytes = labelled_pdf(std::move(bytes), *label);
    if (style.format == "svg") bytes = labelled_svg(std::move(bytes), *label);
  }
  if (style.format == "eps") bytes = without_moment(std::move(bytes));
  if (style.format == "tikz") bytes = with_tex_texts(bytes);
  bytes = marked(std::move(bytes), id, style);
  return plotted;
}

}  // namespace granuscope
