#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace granuscope {

/// How the value at a JSON pointer into summary.json is written in the report:
/// {value, stderr} as 0.0792(41); an integer or a text as it stands; another number with at most four significant
/// digits
/// ("0.3", "1.402", minus as U+2212); null, or an unknown value, as "n/a". Throws std::logic_error if the pointer leads
/// nowhere or to something else.
std::string number_text(const nlohmann::ordered_json& summary, const std::string& pointer);

/// {"key": pointer, "text": number_text} for the report's template.
nlohmann::ordered_json number_cell(const nlohmann::ordered_json& summary, const std::string& pointer);

/// value_with_error without a power of ten, however small the number is.
std::string plain_value_with_error(double value, double standard_error);

/// The same for {value, stderr} that stands in a column with others: without a power of ten however small it is.
nlohmann::ordered_json plain_cell(const nlohmann::ordered_json& summary, const std::string& pointer);

/// The same for a number that stands in a column: with `decimals` digits after the point ("n/a" if it is null).
nlohmann::ordered_json fixed_cell(const nlohmann::ordered_json& summary, const std::string& pointer, int decimals);

}  // namespace granuscope
