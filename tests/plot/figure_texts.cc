#include "plot/figure_texts.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <utility>
#include <vector>

#include "kit/text_parts.h"
#include "plot/axes.h"
#include "plot/gnuplot.h"
#include "plot/plot_texts.h"
#include "render/font.h"
#include "support/files.h"

namespace granuscope {
namespace {

using test::contains;

/// Of a place: how far it is from the middle of the text along it and across.
Corner seen_from(const SvgText& text, const Corner& place) {
  const double x = place.x - text.middle.x, y = place.y - text.middle.y;
  return {x * text.along.x + y * text.along.y, y * text.along.x - x * text.along.y};
}

/// By how much the boxes overlap in the axes of `one`, at least; below 0 if a line along one of them parts the two.
double overlap_in_axes_of(const SvgText& one, const SvgText& other) {
  Range u, v;
  for (const Corner& corner : other.corners()) {
    const Corner seen = seen_from(one, corner);
    u.add(seen.x);
    v.add(seen.y);
  }
  return std::min({one.half_width - u.low, u.high + one.half_width, one.half_height - v.low, v.high + one.half_height});
}

double overlap(const SvgText& one, const SvgText& other) {
  return std::min(overlap_in_axes_of(one, other), overlap_in_axes_of(other, one));
}

/// The mark of a point: its middle, and how far it reaches from there.
struct Mark {
  Corner middle;
  double radius = 0;
};

/// Whether the straight line enters the box by more than `tolerance`.
bool crosses(const SvgText& box, const Corner& from, const Corner& to, double tolerance) {
  const Corner a = seen_from(box, from), b = seen_from(box, to);
  double enter = 0, leave = 1;
  const auto clip = [&](double start, double end, double reach) {
    const double rate = end - start;
    if (rate == 0) {
      if (std::abs(start) > reach) leave = -1;
      return;
    }
    enter = std::max(enter, std::min((-reach - start) / rate, (reach - start) / rate));
    leave = std::min(leave, std::max((-reach - start) / rate, (reach - start) / rate));
  };
  clip(a.x, b.x, box.half_width - tolerance);
  clip(a.y, b.y, box.half_height - tolerance);
  return leave > enter;
}

std::string attribute(const std::string& tag, const std::string& name) {
  const std::size_t at = tag.find(name + "=\"");
  if (at == std::string::npos) return "";
  const std::size_t from = at + name.size() + 2;
  return tag.substr(from, tag.find('"', from) - from);
}

/// The marks of all points of a gnuplot SVG.
std::vector<Mark> marks(const std::string& svg) {
  std::vector<Mark> found;
  const std::string use = "<use ";
  for (std::size_t at = svg.find(use); at != std::string::npos; at = svg.find(use, at + 1)) {
    const std::string tag = svg.substr(at, svg.find('>', at) - at);
    const auto number_after = [&](const std::string& sign) {
      const std::size_t from = tag.find(sign);
      return from == std::string::npos ? 0 : std::atof(tag.c_str() + from + sign.size());
    };
    found.push_back({{number_after("translate("), number_after(",")}, number_after("scale(")});
  }
  return found;
}

constexpr const char* path_data = " d='";

/// The straight pieces of the path that begins at `from`.
void add_pieces(const std::string& svg, std::size_t from, std::vector<std::pair<Corner, Corner>>& pieces) {
  const std::size_t start = from + std::string(path_data).size();
  std::istringstream words(svg.substr(start, svg.find('\'', start) - start));
  Corner before;
  for (std::string word; words >> word;) {
    const Corner here{std::atof(word.c_str() + 1), std::atof(word.c_str() + word.find(',') + 1)};
    if (word[0] == 'L') pieces.emplace_back(before, here);
    if (word[0] == 'M' || word[0] == 'L') before = here;
  }
}

/// The straight pieces of all curves and error bars.
std::vector<std::pair<Corner, Corner>> pieces_of_curves(const std::string& svg) {
  std::vector<std::pair<Corner, Corner>> pieces;
  const std::string curve = "<g id=\"gnuplot_plot_";
  for (std::size_t at = svg.find(curve); at != std::string::npos; at = svg.find(curve, at + 1)) {
    const std::size_t end = svg.find("\n\t</g>", at);
    for (std::size_t from = svg.find(path_data, at); from < end; from = svg.find(path_data, from + 1)) {
      add_pieces(svg, from, pieces);
    }
  }
  return pieces;
}

/// The sides of triangles that show a slope: what is dotted black and no curve.
std::vector<std::pair<Corner, Corner>> pieces_of_triangles(const std::string& svg) {
  std::string rest = svg;
  const std::string curve = "<g id=\"gnuplot_plot_";
  for (std::size_t at = rest.find(curve); at != std::string::npos; at = rest.find(curve, at)) {
    rest.erase(at, rest.find("\n\t</g>", at) - at);
  }
  std::vector<std::pair<Corner, Corner>> pieces;
  const std::string dotted = "stroke='rgb(  0,   0,   0)' stroke-dasharray=";
  for (std::size_t at = rest.find(dotted); at != std::string::npos; at = rest.find(dotted, at + 1)) {
    add_pieces(rest, rest.find(path_data, at), pieces);
  }
  return pieces;
}

bool meet(const std::pair<Corner, Corner>& one, const std::pair<Corner, Corner>& other) {
  const auto side = [](const std::pair<Corner, Corner>& line, const Corner& place) {
    return (line.second.x - line.first.x) * (place.y - line.first.y) -
           (line.second.y - line.first.y) * (place.x - line.first.x);
  };
  return side(one, other.first) * side(one, other.second) < 0 && side(other, one.first) * side(other, one.second) < 0;
}

/// How far a place is from a straight piece.
double away_from(const std::pair<Corner, Corner>& piece, const Corner& place) {
  const auto& [from, to] = piece;
  const double dx = to.x - from.x, dy = to.y - from.y;
  const double along =
      std::clamp(((place.x - from.x) * dx + (place.y - from.y) * dy) / std::max(dx * dx + dy * dy, 1e-9), 0.0, 1.0);
  return std::hypot(from.x + along * dx - place.x, from.y + along * dy - place.y);
}

/// A pixel of rounding, and the side bearings of letters.
constexpr double tolerance_px = 1.5;

}  // namespace

void check_texts(const std::string& svg) {
  const std::string view = attribute(svg, "viewBox");
  const double width = std::atof(view.c_str() + 4), height = std::atof(view.c_str() + view.rfind(' '));
  const std::vector<SvgText> boxes = texts_of_svg(svg);
  const std::vector<Mark> all_marks = marks(svg);
  const std::vector<std::pair<Corner, Corner>> curves = pieces_of_curves(svg);
  CHECK(boxes.size() > 5);
  for (const auto& side : pieces_of_triangles(svg)) {
    INFO("a triangle from " << side.first.x << ", " << side.first.y << " to " << side.second.x << ", "
                            << side.second.y);
    for (const Mark& mark : all_marks) CHECK(away_from(side, mark.middle) > mark.radius);
    for (const auto& piece : curves) CHECK_FALSE(meet(side, piece));
    for (const SvgText& box : boxes) {
      INFO("it lies on " << box.text);
      CHECK_FALSE(crosses(box, side.first, side.second, tolerance_px));
    }
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const SvgText& box = boxes[i];
    INFO(box.text << " in the middle of " << box.middle.x << ", " << box.middle.y << " of " << width << " x "
                  << height);
    for (const Corner& corner : box.corners()) {
      CHECK(corner.x >= 0);
      CHECK(corner.y >= 0);
      CHECK(corner.x <= width);
      CHECK(corner.y <= height);
    }
    for (std::size_t k = 0; k < i; ++k) {
      INFO("it lies on " << boxes[k].text);
      CHECK(overlap(box, boxes[k]) < tolerance_px);
    }
    for (const Mark& mark : all_marks) {
      const Corner seen = seen_from(box, mark.middle);
      INFO("it lies on the point at " << mark.middle.x << ", " << mark.middle.y);
      CHECK(std::hypot(std::max(std::abs(seen.x) - box.half_width, 0.0),
                       std::max(std::abs(seen.y) - box.half_height, 0.0)) > mark.radius - tolerance_px);
    }
    const auto on = std::find_if(curves.begin(), curves.end(), [&](const auto& piece) {
      return crosses(box, piece.first, piece.second, tolerance_px);
    });
    if (on != curves.end())
      FAIL_CHECK("it lies on the line from " << on->first.x << ", " << on->first.y << " to " << on->second.x << ", "
                                             << on->second.y);
  }
}

std::vector<std::string> words_left(const std::string& text, const std::string& catalogue) {
  // What the catalogue gives is marked, so that a word of its own language is not taken for one left over.
  std::string marked;
  std::istringstream lines(catalogue);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t arrow = line.find(" -> ");
    if (line.empty() || line.front() == '#' || line.front() == '.' || arrow == std::string::npos) continue;
    marked += line.substr(0, arrow) + " -> 1\n";
  }
  const std::string rest = in_terms(text, marked);
  std::vector<std::string> words;
  const std::regex word("[A-Za-z]{2,}");
  for (auto it = std::sregex_iterator(rest.begin(), rest.end(), word); it != std::sregex_iterator(); ++it) {
    words.push_back(it->str());
  }
  return words;
}

namespace {

/// Names of axes and curves in a recipe, without those of laws, which are the same in every language.
std::vector<std::string> names_of(const nlohmann::json& fields, const std::string& field) {
  static const std::regex laws("eloy-clement|granusolve|polytope|rejection|no-pair|KPZ");
  if (fields.is_string() && (field == "label" || field == "title"))
    return {std::regex_replace(fields.get<std::string>(), laws, "")};
  std::vector<std::string> names;
  if (!fields.is_structured()) return names;
  for (const auto& [key, inside] : fields.items()) {
    const auto more = names_of(inside, fields.is_object() ? key : field);
    names.insert(names.end(), more.begin(), more.end());
  }
  return names;
}

}  // namespace

void check_at_widths_of_journals(const std::filesystem::path& figures, const std::string& id) {
  for (const char* language : {"en", "fr", "de"}) {
    for (const double width : {86.0, 120.0, 178.0}) {
      INFO(id << " at " << width << " mm, " << language);
      FigureStyle style;
      style.language = language;
      style.format = "svg";
      style.width_mm = width;
      style.font_points = 8;
      const PlottedFigure plotted = plot_again(figures, id, style);
      const std::string& svg = plotted.bytes;
      CHECK(std::atof(attribute(svg, "width").c_str()) == Approx(width / 25.4 * 96).margin(1));
      check_texts(svg);
      // The caption is true of panels side by side and one above the other: it names them by their letters.
      CAPTURE(plotted.caption);
      static const std::regex place("\\b[Ll]eft\\b|\\b[Rr]ight\\b(?!-)|à (gauche|droite)|\\b([Ll]ink|[Rr]echt)s\\b"),
          panels("\\(([a-e])(?:, ([a-e]))?[,)]");
      CHECK_FALSE(std::regex_search(plotted.caption, place));
      for (std::sregex_iterator it(plotted.caption.begin(), plotted.caption.end(), panels);
           it != std::sregex_iterator(); ++it) {
        for (const auto& letter : {it->str(1), it->str(2)})
          CHECK((letter.empty() || svg.find(">(" + letter + ")<") != std::string::npos));
      }
    }
  }
  const auto recipe = nlohmann::json::parse(read_file(figures / (id + ".json")));
  const std::vector<std::string> names = names_of(recipe.at("plot"), "");
  CHECK(names.size() > 5);
  for (const char* language : {"fr", "de"}) {
    for (const std::string& name : names) {
      INFO(id << ", " << language << ": " << name);
      CHECK(words_left(name, std::string(catalogue_of(language))).empty());
    }
  }
  // What TeX would stumble over: a sign that its fonts do not have, a subscript outside mathematics.
  FigureStyle tikz;
  tikz.format = "tikz";
  std::istringstream lines(plot_again(figures, id, tikz).bytes);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("\\node")) continue;
    INFO(id << " as TikZ: " << line);
    const std::string half = "\\ensuremath{{}^1\\!/_2}";
    for (std::size_t at = line.find(half); at != std::string::npos; at = line.find(half)) line.erase(at, half.size());
    CHECK(std::all_of(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; }));
    for (std::size_t at = line.find_first_of("_^"); at != std::string::npos; at = line.find_first_of("_^", at + 1))
      CHECK(line.substr(0, at).ends_with("\\ensuremath{"));
  }
}

}  // namespace granuscope
