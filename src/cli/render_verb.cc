#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cli/verbs.h"
#include "render/draw.h"
#include "report/statistics_json.h"
#include "storage/pile_file.h"
#include "support/number_format.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

struct RenderOptions {
  std::string pile_file;
  std::string image_file;
  std::string window;
  bool no_skip = false;
  bool statistics = false;
  SceneSpec scene;
};

/// "X0,X1,N0,N1".
std::array<double, 4> parse_window(std::string_view text) {
  const auto refuse = [given = std::string(text)] {
    return InputError(
        fmt::format("--window {} is not X0,X1,N0,N1; give two positions in bead diameters from the middle "
                    "and two layers, as in --window=-20,20,0,40",
                    given));
  };
  std::array<double, 4> window{};
  for (std::size_t k = 0; k < window.size(); ++k) {
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (k + 1 == window.size())) throw refuse();
    const std::string_view part = text.substr(0, comma);
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), window[k]);
    if (error != std::errc() || end != part.data() + part.size()) throw refuse();
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return window;
}

ImageMetadata describe(const Pile& pile) {
  return {{"Software", provenance_line(collect_provenance())},
          {"Description", fmt::format("force network of {} columns x {} layers, mu {}, law {}, seed {}, sample {}",
                                      pile.lattice.columns(), pile.lattice.layers(), exact(pile.mu), pile.law,
                                      pile.seed, pile.sample)}};
}

ExitCode render(RenderOptions options, VerbContext& context) {
  if (!options.window.empty()) options.scene.window = parse_window(options.window);
  options.scene.skip_invisible = !options.no_skip;

  const auto started = std::chrono::steady_clock::now();
  const Pile pile = read_pile(options.pile_file);
  const std::chrono::duration<double> reading = std::chrono::steady_clock::now() - started;
  SceneStatistics statistics = draw_pile(pile, options.scene, options.image_file, describe(pile));
  statistics.seconds.read = reading.count();

  context.err << fmt::format("wrote {} with the OpenGL backend {} ({})\n", options.image_file, statistics.backend,
                             statistics.renderer);
  if (options.statistics) context.out << render_statistics_json(statistics);
  return ExitCode::done;
}

}  // namespace

void add_render_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("render", "Draw a stored pile off-screen into a PNG file");
  const auto options = std::make_shared<RenderOptions>();
  SceneSpec& scene = options->scene;
  verb->add_option("FILE", options->pile_file, "pile file (HDF5), as granuscope sample --out writes it")->required();
  verb->add_option("--image", options->image_file, "the picture (PNG)")->required();
  verb->add_option("--scene", scene.scene, "what to draw of the pile")->capture_default_str();
  verb->add_option("--width", scene.width_px, "width of the picture in pixels; mm = 25.4 px / dpi")
      ->capture_default_str();
  verb->add_option("--dpi", scene.dpi, "pixels per inch; text is laid out in points")->capture_default_str();
  verb->add_option("--window", options->window,
                   "X0,X1,N0,N1: part shown, x in bead diameters from the middle, layers from 0; ends included "
                   "(the whole pile if not given)");
  verb->add_option("--colour-map", scene.colour_map, "colours of the forces: grey, viridis or cividis")
      ->capture_default_str();
  verb->add_option("--backend", scene.backend, "how OpenGL is reached: auto, osmesa or egl")->capture_default_str();
  verb->add_flag("--no-skip", options->no_skip, "draw also what cannot be seen; the picture is the same");
  verb->add_flag("--statistics", options->statistics,
                 "print one JSON object on standard output and nothing else there");
  verb->callback([options, &context] { context.action = [options, &context] { return render(*options, context); }; });
}

}  // namespace granuscope
