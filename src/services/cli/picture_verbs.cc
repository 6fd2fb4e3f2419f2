#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "cli/flag_checks.h"
#include "cli/page_options.h"
#include "experiment/experiment.h"
#include "plot/gnuplot.h"
#include "plot/response_field.h"
#include "render/font.h"
#include "render/render_pile.h"
#include "render/scene.h"
#include "report/clean_json.h"
#include "report/run_files.h"
#include "storage/pile_file.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {
namespace {

struct FigureOptions {
  std::string folder, id, templates;
  PageOptions page;
  OutputFile file;
  FigureStyle style;

  FigureOptions() { style.format.clear(); }
};

/// The suffix of the file says the format where no flag does; both are to say the same.
void choose_format(FigureOptions& options) {
  if (!options.file.asked()) {
    if (options.style.format.empty()) options.style.format = "pdf";
    options.file.path = options.id + "." + options.style.format;
    return;
  }
  constexpr SuffixOfFormat known[] = {{".pdf", "pdf"}, {".svg", "svg"},   {".eps", "eps"}, {".ps", "eps"},
                                      {".png", "png"}, {".tikz", "tikz"}, {".tex", "tikz"}};
  options.style.format = format_by_name(options.file.path, options.style.format, known);
}

/// The id of the figure that the report gives this number, as 6 or fig6; what is no number as it stands.
std::string id_of_figure(const std::string& id, const std::string& folder) {
  const std::vector<ListedFigure> figures = list_figures(folder);
  const std::string digits = id.substr(id.starts_with("figure") ? 6 : id.starts_with("fig") ? 3 : 0);
  if (digits.empty() || digits.size() > 4 || digits.find_first_not_of("0123456789") != std::string::npos) {
    std::vector<std::string> ids(figures.size());
    std::ranges::transform(figures, ids.begin(), &ListedFigure::id);
    if (std::ranges::count(ids, id) > 0) return id;
    const auto meant = nearest_name(id, ids);
    const std::string left_out = left_out_by_run(folder);
    if (!meant && left_out.empty()) return id;
    throw InputError("there is no plot {};{}{}", id, meant ? fmt::format(" did you mean {}?", *meant) : "", left_out);
  }
  const std::size_t number = std::stoul(digits);
  if (number >= 1 && number <= figures.size()) return figures[number - 1].id;
  throw InputError("there is no figure {}; `granuscope figure {}` lists them, 1 to {}", id, shell_word(folder),
                   figures.size());
}

ExitCode plot_figure_again(FigureOptions options, VerbContext& context) {
  if (!options.templates.empty()) use_templates(options.templates);
  options.style.font = options.page.font;
  options.style.language = options.page.language;
  if (!options.page.width.empty()) options.style.width_mm = millimetres(options.page.width);
  if (!options.page.font_size.empty()) options.style.font_points = points(options.page.font_size);
  const auto figures = std::filesystem::path(options.folder) / "figures";
  require_results_of_last_run(options.folder, "plot");
  if (options.id.empty()) {
    std::string list;
    for (const ListedFigure& figure : list_figures(options.folder)) {
      list += fmt::format("{}\t{}\t{}{}\n", std::ranges::count(list, '\n') + 1, figure.id, figure.title,
                          figure.plotted ? "" : " (a picture: granuscope render)");
    }
    context.out << aligned(list);
    return ExitCode::done;
  }
  options.id = id_of_figure(options.id, options.folder);
  for (const char* ends : {".csv", ".json"}) {
    if (!options.style.trust_script) require_unchanged(options.folder, "figures/" + options.id, ends);
  }
  choose_format(options);
  const PlottedFigure plotted = plot_again(figures, options.id, options.style);
  options.file.write(plotted.bytes, {options.folder});
  if (plotted.other_script) {
    context.err << fmt::format(
        "figures/{0}.gp is not what figures/{0}.json gives with the templates of now; the figure was plotted from the "
        "latter (--trust-script runs the script as it stands)\n",
        options.id);
  }
  if (!plotted.substitute_font.empty()) tell_substitute(options.style.font, plotted.substitute_font, context);
  context.wrote(options.file.path);
  if (!plotted.caption.empty()) context.out << fmt::format("{}. {}\n", plotted.title, plotted.caption);
  return ExitCode::done;
}

}  // namespace

void add_figure_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "figure", "Plot a figure of a finished run again, in another size, font or format, and print its caption");
  const auto options = std::make_shared<FigureOptions>();
  verb->add_option("OUT", options->folder, "folder of the run")->required();
  verb->add_option("ID", options->id,
                   "which figure: its number in the report, or the name of its files, for example "
                   "scaling-with-friction (a list with titles if not given)");
  verb->add_option("--format", options->style.format,
                   "pdf, svg, eps, png, or tikz, with TeX's own mathematics (by the file's suffix, or pdf)")
      ->transform(CLI::detail::to_lower);
  verb->add_option("--dpi", options->style.dpi, "pixels per inch of a png; its text keeps its size")
      ->capture_default_str();
  add_page_options(
      *verb, options->page,
      "86 (mm), 8.6cm or 3.37in; panels stand one above the other where it is narrow (as in the report, 170mm)",
      "; TeX: set by TeX with its own mathematics, as eps (needs latex and dvips)");
  verb->add_option(
      "--templates", options->templates,
      "folder whose files stand in for those of the same name in templates/: plot scripts, labels, captions, palette");
  verb->add_flag("--trust-script", options->style.trust_script,
                 "run figures/ID.gp as it stands, which can do all that you can; without it the script is filled again "
                 "from figures/ID.json");
  add_output(*verb, "-o,--out", options->file, "file to write (default: ID and the format, here)");
  context.actions[verb] = [options, &context] { return plot_figure_again(*options, context); };
}

namespace {

struct RenderOptions {
  std::string pile_file;
  std::string minus_file;
  OutputFile image;
  std::string window;
  std::string range;
  PageOptions page;
  bool transparent = false;
  bool no_skip = false;
  bool statistics = false;
  SceneSpec scene;
  FilmSpec film;
  FilmOptions frames;
};

/// "X0,X1,N0,N1".
std::array<double, 4> parse_window(std::string_view text) {
  std::array<double, 4> window{};
  if (parse_numbers(text, window)) return window;
  throw InputError(
      "--window {} is not X0,X1,N0,N1; give two positions in bead diameters from the middle and two layers, as in "
      "--window=-20,20,0,40",
      text);
}

/// What the picture says of itself. It names no folder, nor its own file: the same picture is the same bytes anywhere.
ImageMetadata metadata_for(const RenderOptions& options, const std::string& shown) {
  const auto name_of = [](const std::string& file) { return std::filesystem::path(file).filename().string(); };
  const SceneSpec& scene = options.scene;
  std::string command = "granuscope render " + name_of(options.pile_file);
  if (!options.minus_file.empty()) command += " --minus " + name_of(options.minus_file);
  command += options.frames.folder.empty()
                 ? std::string(" --image IMAGE")
                 : fmt::format(" --film DIR --height {} --step {}", options.film.height_px, options.film.step);
  command += fmt::format(" --scene {} --width {} --dpi {}", scene.scene, scene.width_px, exact(scene.dpi));
  if (!scene.font_file.empty()) command += " --font " + shell_word(options.page.font);
  if (!options.page.font_size.empty()) command += fmt::format(" --font-size {}", scene.text_points);
  if (options.page.language != PageOptions().language) command += " --language " + options.page.language;
  if (!options.window.empty()) command += " --window=" + options.window;
  if (!options.range.empty()) command += " --range=" + options.range;
  if (!scene.colour_map.empty()) command += " --colour-map " + scene.colour_map;
  return {{"Title", fmt::format("{} of {}", shown, name_of(options.pile_file))},
          {"Software", provenance_line(collect_provenance())},
          {"Source", command}};
}

/// The mean response of an ensemble over the plane.
SceneStatistics render_ensemble(const RenderOptions& options, const std::string& configuration) {
  if (options.scene.scene != SceneSpec().scene || !options.minus_file.empty()) {
    throw InputError(
        "{} is an ensemble, of which the mean response is shown and no scene of a pile; leave out --scene and --minus",
        options.pile_file);
  }
  const Field field = response_field(open_response(options.pile_file, configuration), {});
  return render_scene(build_field_scene(field, options.scene), options.scene, options.image.path,
                      metadata_for(options, "mean response"));
}

/// What to know of the lowest layers of a pile, where the picture shows them; "" where it does not.
std::string told_of_bottom(const RenderOptions& options) {
  LatticeSpec size;
  (void)read_pile_part(options.pile_file, [&size](const Lattice& lattice) {
    size = {lattice.columns(), lattice.layers()};
    return PileRange{0, 1, 0, 1};
  });
  const int kept = size.layers - bottom_margin;
  if (kept <= 0) {
    return fmt::format(
        "the lowest {} layers follow another law, since no failure below reaches up into them: all that are here\n",
        bottom_margin);
  }
  if ((options.scene.window && (*options.scene.window)[3] < kept)) return "";
  return fmt::format(
      "the lowest {} layers follow another law, since no failure below reaches up into them; --window={:g},{:g},0,{} "
      "leaves them out\n",
      bottom_margin, -0.5 * size.columns, 0.5 * size.columns, kept - 1);
}

ExitCode render_film(RenderOptions options, VerbContext& context) {
  if (!configuration_if_ensemble(options.pile_file).empty()) {
    throw InputError("{} is an ensemble, of which there is one picture; a film slides down a pile", options.pile_file);
  }
  const Pile pile = read_pile(options.pile_file);
  std::optional<Pile> minus;
  if (!options.minus_file.empty()) minus = read_pile(options.minus_file);
  options.film.scene = options.scene;
  options.image.path = Film::name_of(0);
  const Film film(pile, minus ? &*minus : nullptr, options.film, metadata_for(options, options.scene.scene));
  options.frames.force = options.image.force;
  options.frames.inputs = {options.pile_file, options.minus_file};
  write_film(
      options.frames, film.frames(), options.scene.width_px % 2 == 0 && options.film.height_px % 2 == 0,
      fmt::format("{} of {} each", how_many(film.frames(), "frame"), how_many(film.layers_seen(), "layer")),
      [&](std::size_t frame) { film.render(frame, options.frames.folder); }, context);
  context.err << told_of_bottom(options);
  return ExitCode::done;
}

ExitCode render(RenderOptions options, VerbContext& context) {
  apply_page(options.page, options.scene, context);
  if (!options.window.empty()) options.scene.window = parse_window(options.window);
  if (!options.range.empty()) options.scene.range = parse_range(options.range);
  options.scene.skip_invisible = !options.no_skip;
  if (options.transparent) options.scene.background = Background::transparent;
  constexpr std::string_view pictures = " .png .svg .pdf ", films = " .mp4 .gif .avi .mov .mkv .webm ";
  const auto is_one = [](std::string_view suffixes, const std::string& file) {
    return suffixes.find(" " + suffix_of(file) + " ") != std::string_view::npos;
  };
  if (is_one(films, options.frames.folder) || is_one(films, options.image.path)) {
    throw InputError("{} is a film, of which render makes the frames; give a folder for them: --film FOLDER",
                     options.image.path + options.frames.folder);
  }
  if (!options.frames.folder.empty()) return render_film(options, context);
  if (!options.image.asked()) {
    if (is_one(pictures, options.pile_file))
      throw InputError("{0} is a picture, and the pile comes first: granuscope render PILE.h5 {0}", options.pile_file);
    throw InputError("no picture is named; give IMAGE.png after the pile, or --film DIR for a film");
  }

  options.image.require_free({options.pile_file, options.minus_file});
  const std::string configuration = configuration_if_ensemble(options.pile_file);
  const auto render_file = [&] {
    try {
      if (!configuration.empty()) return render_ensemble(options, configuration);
      return render_pile_file({options.pile_file, options.minus_file, options.image.path}, options.scene,
                              metadata_for(options, options.scene.scene));
    } catch (const Interrupted&) {
      throw Interrupted("stopped on request: no picture was written, and the same command renders it from the start");
    }
  };
  const SceneStatistics statistics = render_file();
  context.wrote(options.image.path,
                statistics.backend == "none"
                    ? fmt::format(" without OpenGL ({})", statistics.backend_reason)
                    : fmt::format(" with the OpenGL backend {} ({})", statistics.backend, statistics.renderer));
  if (configuration.empty()) context.err << told_of_bottom(options);
  if (options.statistics) context.out << render_statistics_json(statistics);
  return ExitCode::done;
}

}  // namespace

void add_render_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "render", "Render a stored pile, or the mean response of an ensemble, off-screen into an image file");
  const auto options = std::make_shared<RenderOptions>();
  SceneSpec& scene = options->scene;
  verb->add_option("FILE", options->pile_file,
                   "pile file (HDF5), as granuscope sample --out writes it, or ensemble file, as a run leaves it")
      ->required();
  verb->add_option("--minus", options->minus_file,
                   "scene response: the pile without the overload, of the same seed and sample");
  add_output(*verb, "IMAGE,-o,--image", options->image,
             "the picture: .png, or .svg or .pdf where it has few enough elements");
  verb->add_option("--scene", scene.scene, fmt::format("what to show of the pile: {}", fmt::join(pile_scenes(), ", ")))
      ->capture_default_str();
  add_page_options(
      *verb, options->page,
      fmt::format("width of the picture: 1600 (pixels), 86mm, 8.6cm or 3.37in (default: {} pixels)", scene.width_px));
  verb->add_option("--dpi", scene.dpi, "pixels per inch; text is laid out in points")->capture_default_str();
  verb->add_option("--window", options->window,
                   "X0,X1,N0,N1: part shown, x in bead diameters from the middle, layers from 0; ends included (the "
                   "whole pile if not given)");
  verb->add_option("--range", options->range,
                   "LOW,HIGH: ends of the colour scale, so that pictures compare (from what is shown if not given)");
  scene.colour_map.clear();
  verb->add_option("--colour-map", scene.colour_map,
                   "grey, viridis or cividis; diverging for the scene response (the scene's own if not given)")
      ->transform(CLI::detail::to_lower);
  verb->add_option("--backend", scene.backend,
                   "how OpenGL is reached: auto, osmesa or egl; none: the processor paints, to the same pixels")
      ->capture_default_str();
  verb->add_option("--film", options->frames.folder,
                   "folder: instead of a picture, numbered frames of a window that slides down the pile (--window: all "
                   "that is seen; 1280 pixels wide and 110 dpi unless given)");
  verb->add_option("--height", options->film.height_px, "of a film: height of a frame in pixels")
      ->needs("--film")
      ->capture_default_str();
  verb->add_option("--step", options->film.step, "of a film: layers from frame to frame")
      ->needs("--film")
      ->capture_default_str();
  verb->add_option("-j,--threads", options->frames.threads, "of a film: threads, 0 for all; never changes a pixel")
      ->needs("--film")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_flag("--transparent", options->transparent, "no page behind the picture");
  verb->add_flag("--no-skip", options->no_skip, "paint also what cannot be seen; the picture is the same");
  verb->add_flag("--statistics", options->statistics,
                 "print one JSON object on standard output and nothing else there");
  verb->callback([options, verb] {
    if (!options->frames.folder.empty()) {
      for (const char* flag : {"--image", "--statistics", "--backend"}) {
        if (verb->count(flag) == 0) continue;
        throw CLI::ValidationError(fmt::format(
            "{} has no meaning for a film, whose frames go to --film and are painted by the processor; leave it out",
            flag));
      }
      if (verb->count("--width") == 0) options->scene.width_px = film_width_px;
      if (verb->count("--dpi") == 0) options->scene.dpi = film_dpi;
    }
  });
  context.actions[verb] = [options, &context] { return render(*options, context); };
}

}  // namespace granuscope
