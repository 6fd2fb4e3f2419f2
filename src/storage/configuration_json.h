#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// The lines "key=value" of a configuration as one JSON object, for whoever reads a file without this program: numbers,
/// true and false as such, all else as text.
std::string configuration_json(std::string_view lines);

}  // namespace granuscope
