#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// Every number of a summary.json, with its standard error where it has one, for the text of a paper. `format`: "tex"
/// (\\granuscope{beta} gives 2.522(50), and an unknown name is an error), "csv" (name, value, standard error, text) or
/// "json". Names follow the places of summary.json: "beta", "mu-0.3/c", "claims/D-of-mu/measured". Throws InputError if
/// the text is no summary or the format is not known.
std::string list_numbers(std::string_view summary, const std::string& format);

}  // namespace granuscope
