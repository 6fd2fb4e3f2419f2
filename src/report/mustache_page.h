#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace granuscope {

/// Fills a mustache template from a JSON object of objects, arrays, strings and booleans. {{x}} is escaped for HTML,
/// {{{x}}} is not. Mustache renders a missing key as nothing at all; here it throws std::logic_error naming the key, as
/// do unbalanced sections and values of another type.
std::string fill_page(std::string_view page_template, const nlohmann::ordered_json& values);

/// Walks the template's tags against the values and throws as fill_page does. Inside a section every element that would
/// be rendered is visited; the inside of a section that would not be is only checked for balance.
void require_all_keys(std::string_view page_template, const nlohmann::ordered_json& values);

}  // namespace granuscope
