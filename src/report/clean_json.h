#pragma once
#include <nlohmann/json_fwd.hpp>

namespace granuscope {

/// clean_text on every string value of the document, so that it can be written whatever bytes a user put in.
void clean_strings(nlohmann::ordered_json& document);

}  // namespace granuscope
