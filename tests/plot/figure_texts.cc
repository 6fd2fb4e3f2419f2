#include "plot/figure_texts.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <utility>
#include <vector>

#include "kit/text_parts.h"
#include "plot/gnuplot.h"
#include "render/font.h"

namespace granuscope {
namespace {

using test::contains;

struct TextBox {
  std::string text;
  double left = 0, right = 0, top = 0, bottom = 0;
};

std::string attribute(const std::string& tag, const std::string& name) {
  const std::size_t at = tag.find(name + "=\"");
  if (at == std::string::npos) return "";
  const std::size_t from = at + name.size() + 2;
  return tag.substr(from, tag.find('"', from) - from);
}

std::string without_tags(const std::string& xml) {
  std::string text;
  for (std::size_t i = 0; i < xml.size(); ++i) {
    if (xml[i] == '<') {
      i = xml.find('>', i);
    } else {
      text += xml[i];
    }
  }
  for (const auto& [name, sign] : {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}}) {
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) {
      text.replace(at, std::string(name).size(), sign);
    }
  }
  return text;
}

/// The boxes of all texts of a gnuplot SVG, by the metrics of the font that it names.
std::vector<TextBox> text_boxes(const std::string& svg) {
  std::vector<TextBox> boxes;
  const std::string group = "<g transform=\"translate(";
  for (std::size_t at = svg.find(group); at != std::string::npos; at = svg.find(group, at + 1)) {
    const std::string tag = svg.substr(at, svg.find('>', at) - at);
    const std::size_t begin = svg.find("<text", at), end = svg.find("</text>", at);
    if (begin == std::string::npos || svg.find("</g>", at) < begin) continue;
    const double size = std::atof(attribute(tag, "font-size").c_str());
    const double x = std::atof(tag.c_str() + group.size());
    const double y = std::atof(tag.c_str() + tag.find(',') + 1);
    TextBox box{without_tags(svg.substr(begin, end - begin))};
    if (box.text.find_first_not_of(' ') == std::string::npos) continue;
    const double width = Font(size).width(box.text);
    const std::string anchor = attribute(tag, "text-anchor");
    const double before = anchor == "end" ? width : anchor == "middle" ? 0.5 * width : 0;
    const double above = 0.75 * size, below = 0.2 * size;
    if (contains(tag, "rotate(-90")) {
      box = {box.text, x - above, x + below, y - (width - before), y + before};
    } else {
      box = {box.text, x - before, x + width - before, y - above, y + below};
    }
    boxes.push_back(box);
  }
  return boxes;
}

/// A pixel of rounding, and the side bearings of letters.
constexpr double tolerance_px = 1.5;

}  // namespace

void check_texts(const std::string& svg) {
  const std::string view = attribute(svg, "viewBox");
  const double width = std::atof(view.c_str() + 4), height = std::atof(view.c_str() + view.rfind(' '));
  const std::vector<TextBox> boxes = text_boxes(svg);
  CHECK(boxes.size() > 5);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const TextBox& box = boxes[i];
    INFO(box.text << " reaches from " << box.left << ", " << box.top << " to " << box.right << ", " << box.bottom
                  << " of " << width << " x " << height);
    CHECK(box.left > -tolerance_px);
    CHECK(box.top > -tolerance_px);
    CHECK(box.right < width + tolerance_px);
    CHECK(box.bottom < height + tolerance_px);
    for (std::size_t k = 0; k < i; ++k) {
      const TextBox& other = boxes[k];
      INFO("it lies on " << other.text << " at " << other.left << ", " << other.top);
      const double across = std::min(box.right, other.right) - std::max(box.left, other.left);
      const double down = std::min(box.bottom, other.bottom) - std::max(box.top, other.top);
      CHECK((across < tolerance_px || down < tolerance_px));
    }
  }
}

void check_at_widths_of_journals(const std::filesystem::path& figures, const std::string& id) {
  for (const double width : {86.0, 120.0, 178.0}) {
    INFO(id << " at " << width << " mm");
    FigureStyle style;
    style.format = "svg";
    style.width_mm = width;
    style.font_points = 8;
    const std::string svg = plot_again(figures, id, style).bytes;
    CHECK(std::atof(attribute(svg, "width").c_str()) == Approx(width / 25.4 * 96).margin(1));
    check_texts(svg);
  }
}

}  // namespace granuscope
