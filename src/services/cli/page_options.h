#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "cli/verbs.h"
#include "render/scene.h"

namespace granuscope {
/// How text and width of a picture on paper are given, the same to figure and render.
struct PageOptions {
  std::string width, font = "DejaVu Sans", font_size, language = "en";
};

/// `fonts`: what else --font takes.
void add_page_options(CLI::App& verb, PageOptions& page, const std::string& width_help, const std::string& fonts = "");

void tell_substitute(const std::string& asked, const std::string& taken, VerbContext& context);

/// Of 86mm, 8.6cm or 3.37in.
double millimetres(const std::string& text);
double points(const std::string& text);

/// Numbers with commas between them; whether there are as many as wanted.
bool parse_numbers(std::string_view text, std::span<double> numbers);

/// "LOW,HIGH" of a colour scale.
std::array<double, 2> parse_range(std::string_view text);

/// Of a film, unless asked for otherwise: what a screen shows, with text to be read there.
inline constexpr int film_width_px = 1280;
inline constexpr double film_dpi = 110;

/// Where the frames of a film go, and by how many threads.
struct FilmOptions {
  std::string folder;
  int threads = 0;
  bool force = false;
  std::vector<std::filesystem::path> inputs = {};  ///< which no frame may replace
};
/// Lets `frame` write each frame, and tells `what` was written and how a video is made of it, of any size or of one
/// with `even` sides. Throws InputError if the folder has frames of another film, Interrupted.
void write_film(const FilmOptions& options, std::size_t frames, bool even, const std::string& what,
                const std::function<void(std::size_t)>& frame, VerbContext& context);

/// Width, font, size and language of the text of a picture.
void apply_page(PageOptions& page, SceneSpec& scene, VerbContext& context);

}  // namespace granuscope
