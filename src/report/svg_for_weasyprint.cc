#include "report/svg_for_weasyprint.h"

#include <fmt/format.h>

#include <vector>

namespace granuscope {

namespace {

// Plain searches rather than std::regex, whose recursion does not survive path data of some hundred kilobytes.
constexpr std::string_view reference = "xlink:href='#gp";
constexpr std::string_view identity = " id='gp";
constexpr std::string_view colour_start = " color='";
constexpr std::string_view current_colour = "currentColor";

/// A line of gnuplot's <defs> that defines a point shape: gpPt0 ... gpPt14 and gpDot.
bool defines_shape(std::string_view line) {
  return line.find(" id='gpPt") != std::string_view::npos || line.find(" id='gpDot'") != std::string_view::npos;
}

/// A line that plots one point: refers to a shape and names a colour.
bool draws_point(std::string_view line) {
  return line.find("<use " + std::string(reference)) != std::string_view::npos &&
         line.find(colour_start) != std::string_view::npos;
}

/// Appends `suffix` to the name that follows the first `mark` in the line, if there is one.
void extend_name(std::string& line, std::string_view mark, const std::string& suffix) {
  const std::size_t start = line.find(mark);
  if (start == std::string::npos) return;
  line.insert(line.find('\'', start + mark.size()), suffix);
}

std::string suffix_for(std::vector<std::string>& colours, const std::string& colour) {
  std::size_t index = 0;
  while (index < colours.size() && colours[index] != colour) ++index;
  if (index == colours.size()) colours.push_back(colour);
  return fmt::format("-c{}", index);
}

/// The point's line with its colour taken out and a reference to the shape of that colour.
std::string coloured_point(std::string line, std::vector<std::string>& colours) {
  const std::size_t start = line.find(colour_start);
  const std::size_t value = start + colour_start.size();
  const std::size_t end = line.find('\'', value);
  if (end == std::string::npos) return line;
  const std::string colour = line.substr(value, end - value);
  line.erase(start, end + 1 - start);
  extend_name(line, reference, suffix_for(colours, colour));
  return line;
}

std::string definition_in(std::string line, const std::string& colour, std::size_t index) {
  const std::string suffix = fmt::format("-c{}", index);
  extend_name(line, identity, suffix);
  extend_name(line, reference, suffix);
  for (std::size_t at = line.find(current_colour); at != std::string::npos; at = line.find(current_colour, at)) {
    line.replace(at, current_colour.size(), colour);
    at += colour.size();
  }
  return line;
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = text.find('\n', start);
    const std::size_t next = end == std::string_view::npos ? text.size() : end + 1;
    lines.emplace_back(text.substr(start, next - start));
    start = next;
  }
  return lines;
}

}  // namespace

std::string svg_for_weasyprint(std::string_view svg) {
  std::vector<std::string> lines = lines_of(svg);
  std::vector<std::string> colours;
  for (std::string& line : lines) {
    if (!defines_shape(line) && draws_point(line)) line = coloured_point(line, colours);
  }
  if (colours.empty()) return std::string(svg);

  // The original definitions go: nothing refers to them any more. Their copies stand where the first one stood.
  std::string before, definitions, after;
  std::vector<std::string> shapes;
  for (const std::string& line : lines) {
    if (defines_shape(line)) {
      shapes.push_back(line);
    } else {
      (shapes.empty() ? before : after) += line;
    }
  }
  for (std::size_t i = 0; i < colours.size(); ++i) {
    for (const std::string& shape : shapes) definitions += definition_in(shape, colours[i], i);
  }
  return before + definitions + after;
}

}  // namespace granuscope
