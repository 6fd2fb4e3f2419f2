#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// `bytes` as valid UTF-8 that every reader of XML, HTML and JSON accepts: each malformed sequence and each control
/// character other than tab and line feed becomes U+FFFD; carriage returns become line feeds.
std::string clean_text(std::string_view bytes);

/// Text for HTML and XML, in content or in a quoted attribute: & < > " ' escaped.
std::string escape_markup(std::string_view text);

/// Text as a PDF string: as it is where it is ASCII, else UTF-16.
std::string pdf_string(std::string_view text);

}  // namespace granuscope
