#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace granuscope {

/// Checks that no text of a gnuplot SVG reaches over its edges or lies on another one, on a point or on a line, by the
/// metrics of its font, and that no triangle of a slope lies on any of these.
void check_texts(const std::string& svg);

/// Words of two letters or more that a catalogue leaves as they are: none may be left of an English text.
std::vector<std::string> words_left(const std::string& text, const std::string& catalogue);

/// Checks this of a figure of a run in every language, plotted again at the widths of journals, 86, 120 and 178 mm,
/// with text of 8 pt; that each
/// language has a word for all names of axes and curves; and that TeX can set it.
void check_at_widths_of_journals(const std::filesystem::path& figures, const std::string& id);

}  // namespace granuscope
