#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace granuscope {

/// Text of others (a file name, what another program printed) as a part of a message: line ends and other control
/// characters become single spaces, so that it can neither break the line nor move a terminal's cursor; after `most`
/// bytes it is cut off with an ellipsis, between two characters.
std::string single_line(std::string_view text, std::size_t most = 400);

}  // namespace granuscope
