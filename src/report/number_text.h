#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace granuscope {

/// How a value of summary.json is written in the report: {value, stderr} as 0.0792(41); an integer or a text as it
/// stands; another number with at most four significant digits ("0.3", "1.402", minus as U+2212); null, or an unknown
/// value, as "n/a". `format` may ask for another form: "plain" never has a power of ten, "fixed 2" has so many digits
/// behind the point, "significant 2" in all. Throws std::logic_error for anything else.
std::string format_number(const nlohmann::ordered_json& value, std::string_view format = "");

/// value_with_error without a power of ten, however small the number is.
std::string plain_value_with_error(double value, double standard_error);

}  // namespace granuscope
