#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// What templates/pictures/labels.txt has under that name: the wording of axes, scale bar, arrow and colour scales.
/// Throws std::logic_error if it has nothing: names of labels come from the program, not from the user.
const std::string& label(std::string_view name);

}  // namespace granuscope
