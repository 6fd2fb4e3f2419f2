#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

/// "data:<media type>;base64,...", which a page can hold instead of a link to a file.
std::string data_uri(const std::string& media_type, std::string_view bytes);

}  // namespace granuscope
