#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "plot/figure_captions.h"

namespace granuscope {
/// How a value of summary.json is written in the report: {value, stderr} as 0.0792(41); an integer or a text as it
/// stands; another number with at most four significant digits ("0.3", "1.402", minus as U+2212); null, or an unknown
/// value, as "n/a". `format` may ask for another form: "plain" never has a power of ten, "fixed 2" has so many digits
/// behind the point, "significant 2" in all. Throws std::logic_error for anything else.
std::string format_number(const Json& value, std::string_view format = "");

/// value_with_error without a power of ten, however small the number is.
std::string plain_value_with_error(double value, double standard_error);

/// Which numbers of a summary.json are listed.
struct NumberChoice {
  bool all = false;  ///< or those that a paper quotes: c, D, c_thrust, exponents, and what the claims are judged by
  /// Of these: a name, or a part of it between strokes, as "c" or "mu-0.3"; of all numbers where none of those that a
  /// paper quotes has it. Empty: no choice.
  std::vector<std::string> only = {};
};

/// Numbers of a summary.json, with its standard error where one has it, for the text of a paper. `format`: "tex"
/// (\\granuscope{mu-0.3/c} gives 0.56026(50), and an unknown name is an error), "csv" (name, value, standard error,
/// text) or "json". Names follow the places of summary.json: "beta", "mu-0.3/c", "claims/D-of-mu/measured". Throws
/// InputError if the text is no summary, the format is not known or no number has a name that is asked for.
std::string list_numbers(std::string_view summary, const std::string& format, const NumberChoice& choice);

/// Text that Markdown shows as it stands, on one line, also inside a table.
std::string escape_markdown(std::string_view text);

/// Plain text as HTML in which "c₀ − c" and "μ = 0.3" stay on one line: words joined by = − ≈ ± × and short
/// fractions stand in
/// <span class="formula-text">. Everything is escaped; the text content is the text as it was.
std::string unbroken_formulae(std::string_view text);

/// Plain text as HTML that breaks at spaces only, never after a hyphen: for commands, which a reader copies. A word too
/// long for a line may still break anywhere.
std::string unbroken_words(std::string_view text);

}  // namespace granuscope
