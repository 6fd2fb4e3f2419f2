#pragma once
#include <nlohmann/json_fwd.hpp>

namespace granuscope {

/// What the part of the report asks for beside its numbers: which rows say what, and why others are not known.
/// `summary` holds the numbers at the place where the part finds them.
nlohmann::ordered_json load_overlay(const nlohmann::ordered_json& summary);

}  // namespace granuscope
