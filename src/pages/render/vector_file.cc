#include "render/vector_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "render/font.h"
#include "render/layout.h"
#include "render/palette.h"
#include "render/sample_grid.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// A format, as far as a picture needs it. Units are pixels of the layout, y downwards.
class VectorPage {
 public:
  virtual ~VectorPage() = default;
  virtual void fill(const Path& path, Rgb colour) = 0;
  /// With round ends.
  virtual void stroke(const Path& path, double width, Rgb colour) = 0;
  virtual void begin_clip(const Box& box) = 0;
  virtual void end_clip() = 0;
  virtual std::string finish() = 0;
};

/// A coordinate: a hundredth of a pixel is enough, and stable.
std::string coordinate(double value) {
  std::string text = fmt::format("{:.2f}", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string points_of(const PathStep& step) {
  std::string text;
  for (std::size_t k = 0; k < step.corners; ++k) {
    if (k > 0) text += " ";
    text += fmt::format("{} {}", coordinate(step.corner[k].x), coordinate(step.corner[k].y));
  }
  return text;
}

class SvgPage : public VectorPage {
 public:
  SvgPage(const Layout& layout, double dpi, const ImageMetadata& metadata) {
    text_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {} {}\">\n",
        coordinate(layout.width * 25.4 / dpi), coordinate(layout.height * 25.4 / dpi), layout.width, layout.height);
    std::string about;
    for (const auto& [keyword, value] : metadata) {
      if (keyword == "Title") text_ += "<title>" + escape_markup(clean_text(value)) + "</title>\n";
      about += fmt::format("{}: {}\n", keyword, value);
    }
    text_ += "<desc>" + escape_markup(clean_text(about)) + "</desc>\n";
  }
  void fill(const Path& path, Rgb colour) override {
    text_ += fmt::format("<path fill=\"{}\" d=\"{}\"/>\n", to_hex(colour), data(path));
  }
  void stroke(const Path& path, double width, Rgb colour) override {
    text_ += fmt::format("<path fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\" d=\"{}\"/>\n",
                         to_hex(colour), coordinate(width), data(path));
  }
  void begin_clip(const Box& box) override {
    text_ += fmt::format(
        "<clipPath id=\"plot\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n<g "
        "clip-path=\"url(#plot)\">\n",
        box.left, box.top, box.width, box.height);
  }
  void end_clip() override { text_ += "</g>\n"; }
  std::string finish() override { return text_ + "</svg>\n"; }

 private:
  static std::string data(const Path& path) {
    std::string text;
    for (const PathStep& step : path) {
      text += step.corners == 0 ? "Z" : (step.corners == 3 ? "C" : step.starts ? "M" : "L") + points_of(step);
    }
    return text;
  }
  std::string text_;
};

class PdfPage : public VectorPage {
 public:
  PdfPage(const Layout& layout, double dpi, const ImageMetadata& metadata)
      : points_per_unit_(72 / dpi), width_(layout.width), height_(layout.height), metadata_(metadata) {
    // Units are pixels, y downwards; ends are round.
    content_ =
        fmt::format("{0:.6f} 0 0 -{0:.6f} 0 {1:.4f} cm\n1 J 1 j\n", points_per_unit_, height_ * points_per_unit_);
  }
  void fill(const Path& path, Rgb colour) override { content_ += paint(colour, "rg") + data(path) + "f\n"; }
  void stroke(const Path& path, double width, Rgb colour) override {
    content_ += paint(colour, "RG") + coordinate(width) + " w\n" + data(path) + "S\n";
  }
  void begin_clip(const Box& box) override {
    content_ += fmt::format("q\n{} {} {} {} re W n\n", box.left, box.top, box.width, box.height);
  }
  void end_clip() override { content_ += "Q\n"; }
  std::string finish() override {
    std::string about;
    for (const auto& [keyword, value] : metadata_) {
      const std::string key = keyword == "Source" ? "Subject" : keyword == "Software" ? "Creator" : keyword;
      about += fmt::format(" /{} {}", key, pdf_string(value));
    }
    const std::vector<std::string> objects{
        "<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R /Resources << >> >>",
                    width_ * points_per_unit_, height_ * points_per_unit_),
        fmt::format("<< /Length {} >>\nstream\n{}endstream", content_.size(), content_),
        fmt::format("<< /Producer (granuscope){} >>", about)};
    std::string file = "%PDF-1.4\n";
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < objects.size(); ++k) {
      places.push_back(file.size());
      file += fmt::format("{} 0 obj\n{}\nendobj\n", k + 1, objects[k]);
    }
    const std::size_t table = file.size();
    file += fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects.size() + 1);
    for (const std::size_t place : places) file += fmt::format("{:010} 00000 n \n", place);
    file += fmt::format("trailer\n<< /Size {} /Root 1 0 R /Info 5 0 R >>\nstartxref\n{}\n%%EOF\n", objects.size() + 1,
                        table);
    return file;
  }

 private:
  static std::string paint(Rgb colour, const char* operation) {
    return fmt::format("{:.4f} {:.4f} {:.4f} {}\n", colour.r / 255.0, colour.g / 255.0, colour.b / 255.0, operation);
  }
  static std::string data(const Path& path) {
    std::string text;
    for (const PathStep& step : path) {
      text += step.corners == 0 ? "h\n"
                                : points_of(step) + (step.corners == 3 ? " c\n"
                                                     : step.starts     ? " m\n"
                                                                       : " l\n");
    }
    return text;
  }
  double points_per_unit_;
  int width_, height_;
  ImageMetadata metadata_;
  std::string content_;
};

PathStep move_to(double x, double y) { return {true, 1, {{{x, y}}}}; }
PathStep line_to(double x, double y) { return {false, 1, {{{x, y}}}}; }
PathStep close() { return {false, 0, {}}; }

Path rectangle(double left, double top, double right, double bottom) {
  return {move_to(left, top), line_to(right, top), line_to(right, bottom), line_to(left, bottom), close()};
}

/// Viewers show the page between boxes that only touch.
constexpr double overlap_px = 0.3;

/// The elements, weak before strong, those of one level and width in one path.
void paint_elements(const Scene& scene, const Layout& layout, const LevelTable& table, VectorPage& page) {
  std::vector<Element> elements;
  scene.elements(scene.extent, [&](const Element& element) {
    if (table.visible[element.level]) elements.push_back(element);
  });
  std::ranges::stable_sort(elements, [](const Element& a, const Element& b) { return a.level < b.level; });
  const double scale = scene.pixels_per_diameter;
  const auto across = [&](double x) { return layout.plot.left + (x - scene.extent.x0) * scale; };
  const auto down = [&](double z) { return layout.plot.top + (z - scene.extent.z0) * scale; };
  for (std::size_t k = 0; k < elements.size();) {
    const Element& first = elements[k];
    const auto alike = [&](const Element& other) {
      return other.level == first.level && other.width == first.width && other.outline == first.outline;
    };
    Path path;
    for (; k < elements.size() && alike(elements[k]); ++k) {
      const Element& element = elements[k];
      const double x0 = across(element.x0), y0 = down(element.z0), x1 = across(element.x1), y1 = down(element.z1);
      if (element.outline == Outline::box) {
        const Path box = rectangle(x0, y0, x1 + overlap_px, y1 + overlap_px);
        path.insert(path.end(), box.begin(), box.end());
      } else {
        path.push_back(move_to(x0, y0));
        path.push_back(line_to(x1, y1));  // of no length for a bead: its round ends are the disc
      }
    }
    const Rgb colour = table.full_colour[first.level];
    if (first.outline == Outline::box) {
      page.fill(path, colour);
    } else {
      page.stroke(path, first.width * scale, colour);
    }
  }
}

void paint_legend(const Scene& scene, const Box& box, const ColourScale& scale, VectorPage& page) {
  constexpr int slices = 128;
  const bool wedge = scene.glyph == Glyph::force_bar;
  for (int k = 0; k < slices; ++k) {
    const double a = static_cast<double>(k) / slices, b = std::min(1.0, static_cast<double>(k + 1.2) / slices);
    const double left = box.left + a * box.width, right = box.left + b * box.width;
    const double foot = box.bottom(), high_left = wedge ? foot - a * box.height : box.top;
    const double high_right = wedge ? foot - b * box.height : box.top;
    const double share = (k + 0.5) / slices;
    page.fill(
        {move_to(left, foot), line_to(right, foot), line_to(right, high_right), line_to(left, high_left), close()},
        scale.at(scene.values.sign == Sign::both ? 2 * share - 1 : share));
  }
}

void paint_labels(const Layout& layout, const Font& font, Rgb ink, VectorPage& page) {
  for (const Label& label : layout.labels) {
    Path path = font.outline(label.text);
    for (PathStep& step : path) {
      for (Corner& corner : step.corner) {
        // A text that reads upwards begins at the bottom of its box, its base line to the right of its ascent.
        corner = label.reading == Reading::across
                     ? Corner{label.box.left + corner.x, label.box.top + font.ascent() + corner.y}
                     : Corner{label.box.left + font.ascent() + corner.y, label.box.bottom() - corner.x};
      }
    }
    page.fill(path, ink);
  }
}

}  // namespace

std::array<int, 2> write_vector(const std::filesystem::path& path, const Scene& scene, const SceneSpec& spec,
                                const ImageMetadata& metadata) {
  const std::uint64_t elements = scene.counts.drawn + scene.counts.aggregated;
  if (elements > most_vector_elements) {
    throw InputError(
        "the scene has {} elements, and a vector picture of more than {} is slow to open; choose a window, or write a "
        "PNG",
        elements, most_vector_elements);
  }
  const Palette& palette = Palette::builtin();
  const ColourScale scale(palette, scene.colour_map, scene.values.sign);
  const LevelTable table = make_level_table(scale, scene.values, scene.glyph, 1e9);  // no samples, nothing is thinned
  const Font font = font_of(spec);
  const Layout layout = lay_out(spec, scene, font);
  std::unique_ptr<VectorPage> page;
  if (suffix_of(path) == ".pdf") {
    page = std::make_unique<PdfPage>(layout, spec.dpi, metadata);
  } else {
    page = std::make_unique<SvgPage>(layout, spec.dpi, metadata);
  }
  if (spec.background == Background::page) page->fill(rectangle(0, 0, layout.width, layout.height), scale.page());
  page->begin_clip(layout.plot);
  paint_elements(scene, layout, table, *page);
  page->end_clip();
  paint_legend(scene, layout.legend, scale, *page);
  for (const Rule& rule : layout.rules) {
    page->fill(rectangle(rule.box.left, rule.box.top, rule.box.right(), rule.box.bottom()),
               palette.colour(rule.colour));
  }
  const Rgb ink = palette.colour("ink");
  if (!layout.arrow.empty()) {
    Path arrow{move_to(layout.arrow[0].x, layout.arrow[0].y)};
    for (std::size_t k = 1; k < layout.arrow.size(); ++k)
      arrow.push_back(line_to(layout.arrow[k].x, layout.arrow[k].y));
    arrow.push_back(close());
    page->fill(arrow, ink);
  }
  paint_labels(layout, font, ink, *page);
  write_file(path, page->finish());
  return {layout.width, layout.height};
}

}  // namespace granuscope
