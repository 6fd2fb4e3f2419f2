#include "render/picture_file.h"

#include <fmt/format.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "render/font.h"
#include "render/layout.h"
#include "render/palette.h"
#include "render/sample_grid.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/progress.h"

namespace granuscope {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }  // errors are looked for before, by fflush
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// libpng reports through a callback and leaves by longjmp. No object with a destructor may then lie between the setjmp
/// and the call into libpng, so that everything with one lives in the callers of encode_...().
struct PngError {
  std::array<char, 256> message{};
};

extern "C" void note_png_error(png_structp png, png_const_charp message) {
  auto* error = static_cast<PngError*>(png_get_error_ptr(png));
  std::snprintf(error->message.data(), error->message.size(), "%s", message);
  std::longjmp(*png_set_longjmp_fn(png, std::longjmp, sizeof(std::jmp_buf)), 1);
}

extern "C" void ignore_png_warning(png_structp, png_const_charp) {}

/// zlib's level and strategy and libpng's row filter, by measurement of all levels and filters on every scene, piles of
/// 70 x 60, 500 x 200 and 1000 x 1000 beads at 800, 2000 and 8000 px. Oblique lines and discs on a page repeat as they
/// are, so that every filter enlarges the file (none 0.93 MB, up 1.00, sub 1.06, average 1.15, paeth 1.12, chosen row
/// by row 1.00: forces of 70 x 60 at 2000 px), and level 2 takes a third (0.023 s) of the time of level 6 (0.069 s) for
/// 10 % more bytes; level 9 takes twelve times as long as that for 1 % fewer. In greys, looking for runs alone (Z_RLE)
/// is faster by another 1.4 to 2.4 times with -21 to +14 % of the bytes (0.049 s and 2.60 MB become 0.020 s and 2.60
/// MB: forces of 1000 x 1000 at 2000 px); in colours, where a pixel takes several bytes, it finds none.
constexpr int compression_level = 2;
constexpr int row_filter = PNG_FILTER_NONE;
constexpr int grey_strategy = Z_RLE;

/// What the encoder holds between rows.
struct Encoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  PngError error;
  ~Encoder() { png_destroy_write_struct(&png, &info); }
};

bool encode_header(Encoder* to, std::FILE* file, const PngWriter::Form* form, png_text* texts, int text_count) {
  to->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &to->error, note_png_error, ignore_png_warning);
  if (to->png == nullptr) return false;
  to->info = png_create_info_struct(to->png);
  if (to->info == nullptr || setjmp(png_jmpbuf(to->png)) != 0) return false;
  constexpr double metres_per_inch = 0.0254;
  const auto pixels_per_metre = static_cast<png_uint_32>(std::lround(form->dpi / metres_per_inch));
  png_init_io(to->png, file);
  png_set_user_limits(to->png, PNG_USER_WIDTH_MAX, PNG_USER_HEIGHT_MAX);
  png_set_IHDR(to->png, to->info, static_cast<png_uint_32>(form->width), static_cast<png_uint_32>(form->height), 8,
               form->channels == Channels::grey  ? PNG_COLOR_TYPE_GRAY
               : form->channels == Channels::rgb ? PNG_COLOR_TYPE_RGB
                                                 : PNG_COLOR_TYPE_RGB_ALPHA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(to->png, to->info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_pHYs(to->png, to->info, pixels_per_metre, pixels_per_metre, PNG_RESOLUTION_METER);
  if (text_count > 0) png_set_text(to->png, to->info, texts, text_count);
  png_set_compression_level(to->png, compression_level);
  if (form->channels == Channels::grey) png_set_compression_strategy(to->png, grey_strategy);
  png_set_filter(to->png, PNG_FILTER_TYPE_BASE, row_filter);
  png_write_info(to->png, to->info);
  return true;
}

bool encode_row(Encoder* to, png_const_bytep row) {
  if (setjmp(png_jmpbuf(to->png)) != 0) return false;
  if (interruption_requested()) png_error(to->png, "interrupted");
  png_write_row(to->png, row);
  return true;
}

bool encode_end(Encoder* to) {
  if (setjmp(png_jmpbuf(to->png)) != 0) return false;
  png_write_end(to->png, nullptr);
  return true;
}

/// The stored channels of one row of pixels.
void pack(const std::uint8_t* pixels, int width, Channels channels, png_bytep row) {
  if (channels == Channels::grey) {
    for (int x = 0; x < width; ++x) row[x] = pixels[4 * x];
  } else if (channels == Channels::rgb) {
    for (int x = 0; x < width; ++x) {
      row[3 * x] = pixels[4 * x];
      row[3 * x + 1] = pixels[4 * x + 1];
      row[3 * x + 2] = pixels[4 * x + 2];
    }
  } else {
    std::memcpy(row, pixels, 4 * static_cast<std::size_t>(width));
  }
}

void require_keyword(const std::string& keyword) {
  const bool printable = std::ranges::all_of(keyword, [](char c) { return c >= ' ' && c <= '~'; });
  if (keyword.empty() || keyword.size() > 79 || !printable || keyword.front() == ' ' || keyword.back() == ' ') {
    throw InputError(
        "'{}' cannot be a keyword of a PNG: it must be 1 to 79 printable ASCII characters that neither start nor end "
        "with a blank",
        keyword);
  }
}

}  // namespace

struct PngWriter::State {
  State(const std::filesystem::path& path_, const Form& form_)
      : path(path_),
        form(form_),
        target(path),
        file(std::fopen(target.temporary_path().c_str(), "wb")),
        row(4 * static_cast<std::size_t>(form.width)) {}

  [[noreturn]] void fail() const {
    const int reason = errno;
    throw_if_interrupted();
    throw EnvironmentError("cannot write '{}': {} Nothing was left behind.", path.string(),
                           reason != 0 ? system_reason(reason) : fmt::format("{}.", encoder.error.message.data()));
  }

  std::filesystem::path path;
  Form form;
  AtomicFile target;
  File file;
  Encoder encoder;
  std::vector<png_byte> row;
};

PngWriter::PngWriter(const std::filesystem::path& path, const Form& form, const ImageMetadata& metadata) {
  if (form.width < 1 || form.height < 1) {
    throw InputError("an image of {} x {} pixels cannot be written to {}: it is empty", form.width, form.height,
                     path.string());
  }
  if (!(form.dpi > 0) || !std::isfinite(form.dpi)) throw InputError("{} dpi is no resolution for an image", form.dpi);
  ImageMetadata texts_owned = metadata;  // libpng asks for pointers it could write through
  std::vector<png_text> texts;
  for (auto& [keyword, text] : texts_owned) {
    require_keyword(keyword);
    png_text entry = {};
    entry.compression = PNG_ITXT_COMPRESSION_NONE;
    entry.key = keyword.data();
    entry.text = text.data();
    entry.itxt_length = text.size();
    texts.push_back(entry);
  }
  state_ = std::make_unique<State>(path, form);
  if (state_->file == nullptr) {
    throw EnvironmentError("cannot write {}: {}; choose a folder that exists and may be written to", path.string(),
                           std::generic_category().message(errno));
  }
  errno = 0;
  if (!encode_header(&state_->encoder, state_->file.get(), &form, texts.data(), static_cast<int>(texts.size()))) {
    state_->fail();
  }
}

PngWriter::~PngWriter() = default;

void PngWriter::add(const Image& rows) {
  if (rows.width != state_->form.width) throw std::logic_error("rows of another width than the PNG they are for");
  errno = 0;
  for (int y = 0; y < rows.height; ++y) {
    pack(rows.rgba.data() + rows.offset(0, y), rows.width, state_->form.channels, state_->row.data());
    if (!encode_row(&state_->encoder, state_->row.data())) state_->fail();
  }
}

void PngWriter::commit() {
  errno = 0;
  if (!encode_end(&state_->encoder) || std::fflush(state_->file.get()) != 0) state_->fail();
  state_->file.reset();
  state_->target.commit();
}

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
