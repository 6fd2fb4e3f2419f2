#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {

/// Number of letters to insert, remove, replace or swap with their neighbour to turn one word into the other.
int edit_distance(std::string_view a, std::string_view b);

/// The known name that a mistyped one most probably means, or nothing if none is near.
std::optional<std::string> nearest_name(std::string_view mistyped, const std::vector<std::string>& known);

}  // namespace granuscope
