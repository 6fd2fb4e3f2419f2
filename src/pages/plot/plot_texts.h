#pragma once
#include <string>
#include <string_view>

#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "sampling/sampler_spec.h"

namespace granuscope {
/// The categorical colours of templates/palette.txt (Okabe and Ito) by name, as "#rrggbb": black, orange, sky_blue,
/// bluish_green, yellow, blue, vermilion, reddish_purple, and frame for decorations. Throws std::logic_error if the
/// palette lacks one.
TemplateVariables plot_colours();

/// A text with the phrases of a catalogue (templates/plot/labels.txt has its form) replaced as whole words, a longer
/// one before one that it holds, and its decimal points. Throws InputError for a line of the catalogue that is none.
std::string in_terms(const std::string& text, std::string_view catalogue);

/// What fills the places of captions, with the decimal sign of a catalogue; where that is a comma, numbers in a row are
/// parted by semicolons. Words are translated where the catalogue has all those of a place, and stay otherwise: reasons
/// are sentences, of which half would be translated.
TemplateVariables in_words_of(TemplateVariables variables, std::string_view catalogue);

/// The catalogue by which texts about friction speak of what else an experiment varies, and those about contacts at 30
/// degrees of another angle; empty for these.
std::string terms_of(const ScanParameter& parameter, double angle = usual_angle);

/// The catalogue of a language that is built in: "en" (nothing changes), "fr", "de". Throws InputError for another.
std::string_view catalogue_of(const std::string& language);

}  // namespace granuscope
