#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// Text that Markdown shows as it stands, on one line, also inside a table.
std::string escape_markdown(std::string_view text);

}  // namespace granuscope
