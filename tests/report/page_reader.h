#pragma once
#include <string>
#include <utility>
#include <vector>

namespace granuscope::synthetic {

/// (data-key, text) of every element of the page that carries a data-key, in reading order; tags inside are dropped and
/// character references resolved.
std::vector<std::pair<std::string, std::string>> keyed_texts(const std::string& html);

/// Compares each keyed text with an independent formatting of summary.json (written here with printf, not with the
/// program's number formats). Returns one line for each that differs or whose key leads nowhere.
std::vector<std::string> differences(const std::string& html, const std::string& summary);

}  // namespace granuscope::synthetic
