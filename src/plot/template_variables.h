#pragma once
#include <map>
#include <string>
#include <string_view>

namespace granuscope {

/// What fills the places of a template, by name. An empty text also means "not there" to a section.
using TemplateVariables = std::map<std::string, std::string>;

/// Fills a template of a script or a caption (support/text_template.h). Nothing is escaped: scripts and captions are
/// not HTML. Throws std::logic_error for a name without a text, also in a section that is not written, and for a text
/// that no place asks for: a place that silently stays empty would be a wrong figure.
std::string fill_template(std::string_view text, const TemplateVariables& variables);

}  // namespace granuscope
