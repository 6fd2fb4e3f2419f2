#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace granuscope {

/// What the part of the report asks for beside its numbers: which rows say what, and why others are not known.
/// `summary` holds the numbers at `base`, where the part finds them.
nlohmann::ordered_json load_overlay(const nlohmann::ordered_json& summary, const std::string& base);

}  // namespace granuscope
