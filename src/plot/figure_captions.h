#pragma once
#include <string>
#include <vector>

#include "plot/figure.h"
#include "plot/template_variables.h"

namespace granuscope {

/// The template of a figure's captions and what fills it.
struct Wording {
  std::string captions;  ///< "plot/response_profiles.captions", below templates/
  TemplateVariables variables;
  std::string terms = {};  ///< terms_of(what varies), in which all but what the paper says is put
};

/// Fills `figure`'s title, caption, details, alternative and paper_says from its wording: headings in square
/// brackets, each followed by its text, which becomes one paragraph. Throws std::logic_error if one is missing.
void set_captions(Figure& figure, const Wording& wording);

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

/// "one point", "two points".
std::string points_in_words(std::size_t count);

/// A number as a caption shows it: at most `digits` significant digits, no trailing zeros, typographic minus.
std::string caption_number(double value, int digits = 4);

}  // namespace granuscope
