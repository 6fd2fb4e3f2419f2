#pragma once
#include <array>
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

/// Width, font, size and language of the text of a picture.
void apply_page(PageOptions& page, SceneSpec& scene, VerbContext& context);

}  // namespace granuscope
