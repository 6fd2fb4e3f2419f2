#pragma once
#include <map>
#include <string>
#include <string_view>

namespace granuscope {

/// Text for the gaps of a template, by name. An empty text also means "not there" to a section.
using Gaps = std::map<std::string, std::string>;

/// Fills a plot template: {{name}} becomes its text as it stands (nothing is escaped: scripts and captions are not
/// HTML);
/// {{#name}}...{{/name}} stays if the text is not empty, {{^name}}...{{/name}} if it is; sections may nest.
/// What is filled in is never read as a template again. Throws std::logic_error for a name without a text, a section
/// that is not closed, or a text no gap asks for: a gap that silently stays empty would be a wrong figure.
std::string fill_in(std::string_view text, const Gaps& gaps);

}  // namespace granuscope
