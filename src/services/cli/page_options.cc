#include "cli/page_options.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>

#include "cli/flag_checks.h"
#include "ensemble/ensemble_runner.h"
#include "experiment/experiment_file.h"
#include "plot/plot_texts.h"
#include "render/font.h"
#include "render/layout.h"
#include "render/render_pile.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"
#include "support/progress.h"

namespace granuscope {
namespace {

struct Unit {
  std::string_view name;
  double scale;
};

/// A number above 0 with a unit behind it, or without, which is the first one; 0 for any other text.
double measure_in(const std::string& text, std::initializer_list<Unit> units) {
  if (const std::string odd = odd_sign_in(text); !odd.empty()) throw InputError("{}: {}", text, odd);
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !(number > 0)) return 0;
  const std::string unit = CLI::detail::to_lower(CLI::detail::trim_copy(end));
  for (const Unit& known : units) {
    if (unit.empty() || unit == known.name) return number * known.scale;
  }
  return 0;
}

/// Of a width on paper at so many pixels per inch, or the number of pixels itself. What no picture can have is clipped
/// to what is refused later.
int pixels(const std::string& text, double dpi) {
  constexpr double most = 1e9;
  const double width = measure_in(text, {{"px", 1}, {"mm", dpi / 25.4}, {"cm", dpi / 2.54}, {"in", dpi}});
  if (width > 0) return static_cast<int>(std::lround(std::clamp(width, 1.0, most)));
  throw InputError("--width {} is no width; write 1600 (pixels), 86mm, 8.6cm or 3.37in", text);
}

}  // namespace

void add_page_options(CLI::App& verb, PageOptions& page, const std::string& width_help, const std::string& fonts) {
  verb.add_option("--width", page.width, width_help);
  verb.add_option(
          "--font", page.font,
          "of all text, as fontconfig names it; of one that is not here fontconfig's substitute is taken, and named" +
              fonts)
      ->capture_default_str();
  verb.add_option("--font-size", page.font_size, "8pt, or 8; room around the axes grows with it");
  verb.add_option("--language", page.language, "of its texts, caption and decimal point: en, fr or de")
      ->transform(CLI::detail::to_lower)
      ->capture_default_str();
}

void tell_substitute(const std::string& asked, const std::string& taken, VerbContext& context) {
  context.err << fmt::format("there is no font {} here, {} takes its place (`fc-list : family` lists all)\n",
                             single_line(asked), single_line(taken));
}

double points(const std::string& text) {
  const double size = measure_in(text, {{"pt", 1}});
  if (size > 0) return size;
  throw InputError("--font-size {} is no size of text; write 8pt or 8", text);
}

double millimetres(const std::string& text) {
  const double width = measure_in(text, {{"mm", 1}, {"cm", 10}, {"in", 25.4}});
  if (width > 0) return width;
  throw InputError("--width {} is no width; write 86mm, 8.6cm or 3.37in", text);
}

bool parse_numbers(std::string_view text, std::span<double> numbers) {
  const std::vector<std::string> parts = parts_between(text, ",");
  bool whole = parts.size() == numbers.size();
  for (std::size_t k = 0; whole && k < numbers.size(); ++k) whole = read_whole(std::string_view(parts[k]), numbers[k]);
  return whole;
}

std::array<double, 2> parse_range(std::string_view text) {
  std::array<double, 2> range{};
  if (parse_numbers(text, range)) return range;
  throw InputError(
      "--range {} is not LOW,HIGH; give the two ends of the colour scale, as in --range=0,1.5 or --range=-1,1", text);
}

void apply_page(PageOptions& page, SceneSpec& scene, VerbContext& context) {
  if (!page.width.empty()) scene.width_px = pixels(page.width, scene.dpi);
  if (!page.font_size.empty()) scene.text_points = points(page.font_size);
  (void)catalogue_of(page.language);  // refuses a language that there is not
  use_language_of_pictures(page.language);
  if (page.font == PageOptions().font) return;
  const auto match = match_font(page.font);
  if (!match) {
    throw EnvironmentError(
        "fc-match, which finds a font by its name, is not here; install fontconfig or leave out --font");
  }
  if (match->is_substitute) tell_substitute(page.font, match->family, context);
  page.font = match->family;
  scene.font_file = match->file;
}

namespace {

/// Frames of another film would be taken for some of this one.
void require_no_other_frames(const FilmOptions& options, std::size_t frames) {
  for (const fs::path& entry : entries_of(options.folder)) {
    const std::string name = entry.filename().string();
    if (!name.starts_with("frame-") || entry.extension() != ".png") continue;
    if (name < Film::name_of(frames).string()) {
      OutputFile{entry.string(), options.force}.require_free(options.inputs);
      continue;
    }
    throw InputError(
        "{}: this is a frame of another film, which would be mixed with the {} of this one; take it away or "
        "choose another --film",
        entry.string(), how_many(frames, "frame"));
  }
}

}  // namespace

void write_film(const FilmOptions& options, std::size_t frames, bool even, const std::string& what,
                const std::function<void(std::size_t)>& frame, VerbContext& context) {
  const std::filesystem::path folder = options.folder;
  make_folder(folder);
  require_no_other_frames(options, frames);
  const auto start = std::chrono::steady_clock::now();
  try {
    for_each_index(frames, options.threads, [&](std::size_t one) {
      throw_if_interrupted();
      frame(one);
    });
  } catch (const Interrupted&) {
    throw Interrupted("stopped on request: each frame that is there is whole, and the same command renders them all");
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  context.wrote(fmt::format("{} to {} ({:.0f} a second); a video of them{}:", what, options.folder,
                            static_cast<double>(frames) / seconds,
                            find_program("ffmpeg") ? "" : " takes ffmpeg, which is not here"));
  context.err << fmt::format("  ffmpeg -framerate 25 -i {} {}-pix_fmt yuv420p film.mp4\n",
                             shell_word(CLI::detail::find_and_replace(folder.string(), "%", "%%") + "/frame-%05d.png"),
                             even ? "" : "-vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' ");  // no yuv420p has odd sides
}

}  // namespace granuscope
