#include "render/font.h"

#include <fmt/format.h>
#include <ft2build.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include "support/error.h"
#include "support/plain_text.h"
#include "support/process.h"

namespace granuscope {
namespace {

constexpr const char* font_path = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

/// Highest and lowest ink of the characters our labels use (letters, digits, brackets, slash), in ems of DejaVu Sans.
constexpr double ascent_em = 0.78;
constexpr double descent_em = 0.24;
constexpr double digit_height_em = 0.729;

/// Whole numbers of 1/64 pixel, FreeType's unit.
FT_Pos to_26_6(double pixels) { return static_cast<FT_Pos>(std::lround(pixels * 64)); }

[[noreturn]] void fail(FT_Error error, const char* step, const std::string& font = font_path) {
  throw EnvironmentError(
      "FreeType cannot {} {} (error {}), so a picture would lack its labels; install fonts-dejavu-core", step, font,
      error);
}

/// Code points of a UTF-8 text of our own making (labels): no checks beyond the length.
std::vector<FT_ULong> code_points(std::string_view text) {
  std::vector<FT_ULong> points;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t length = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
    FT_ULong point = length == 1 ? lead : lead & (0xffU >> (length + 1));
    for (std::size_t k = 1; k < length && i + k < text.size(); ++k) {
      point = point << 6 | (static_cast<unsigned char>(text[i + k]) & 0x3fU);
    }
    points.push_back(point);
    i += length;
  }
  return points;
}

}  // namespace

struct Font::Face {
  Face(const std::string& file, double size_px) {
    if (const FT_Error error = FT_Init_FreeType(&library); error != 0) fail(error, "start for");
    open(face, file.empty() ? font_path : file, size_px);
    if (!file.empty()) open(reserve, font_path, size_px);
  }
  Face(const Face&) = delete;
  Face& operator=(const Face&) = delete;
  ~Face() { FT_Done_FreeType(library); }  // and its faces

  void open(FT_Face& one, const std::string& file, double size_px) const {
    FT_Error error = FT_New_Face(library, file.c_str(), 0, &one);
    // At 72 dpi a point is a pixel, so that the size need not be a whole number of either.
    if (error == 0) error = FT_Set_Char_Size(one, 0, to_26_6(size_px), 72, 72);
    if (error == 0) return;
    FT_Done_FreeType(library);
    fail(error, "read", file);
  }

  /// Loads each glyph in turn and calls act(glyph slot, pen position in pixels). Positions are not rounded, so that the
  /// spacing is right at small sizes too; hinting moves outlines vertically only, which keeps the base line sharp.
  template <typename Act>
  double walk(std::string_view text, Act&& act) {
    double pen = 0;
    FT_UInt previous = 0;
    for (const FT_ULong point : code_points(text)) {
      const bool lacks = reserve != nullptr && FT_Get_Char_Index(face, point) == 0;
      const FT_Face used = lacks ? reserve : face;
      const FT_UInt glyph = FT_Get_Char_Index(used, point);
      FT_Vector kerning = {0, 0};
      if (previous != 0 && !lacks) FT_Get_Kerning(face, previous, glyph, FT_KERNING_UNFITTED, &kerning);
      pen += static_cast<double>(kerning.x) / 64;
      if (const FT_Error error = FT_Load_Glyph(used, glyph, FT_LOAD_TARGET_LIGHT | FT_LOAD_NO_BITMAP); error != 0) {
        fail(error, "load a glyph of");
      }
      act(used->glyph, pen);
      pen += static_cast<double>(used->glyph->linearHoriAdvance) / 65536;
      previous = lacks ? 0 : glyph;
    }
    return pen;
  }

  FT_Library library = nullptr;
  FT_Face face = nullptr;
  FT_Face reserve = nullptr;  ///< for signs that the other one lacks
};

Font::Font(double size_px, const std::string& file) : face_(std::make_unique<Face>(file, size_px)), size_px_(size_px) {}

Font::~Font() = default;

int Font::width(std::string_view text) const {
  return static_cast<int>(std::ceil(face_->walk(text, [](FT_GlyphSlot, double) {}))) + 1;
}
int Font::ascent() const { return static_cast<int>(std::ceil(ascent_em * size_px_)); }
int Font::descent() const { return static_cast<int>(std::ceil(descent_em * size_px_)); }
double Font::digit_height() const { return digit_height_em * size_px_; }

CoverageMask Font::paint(std::string_view text) const {
  CoverageMask mask;
  mask.width = width(text);
  mask.height = ascent() + descent();
  mask.coverage.resize(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height));
  face_->walk(text, [&](FT_GlyphSlot slot, double pen) {
    const double whole = std::floor(pen);
    FT_Outline_Translate(&slot->outline, to_26_6(pen - whole), 0);
    if (const FT_Error error = FT_Render_Glyph(slot, FT_RENDER_MODE_NORMAL); error != 0) fail(error, "show a glyph of");
    const FT_Bitmap& bitmap = slot->bitmap;
    for (int row = 0; row < static_cast<int>(bitmap.rows); ++row) {
      for (int column = 0; column < static_cast<int>(bitmap.width); ++column) {
        const int x = static_cast<int>(whole) + slot->bitmap_left + column;
        const int y = ascent() - slot->bitmap_top + row;
        if (x < 0 || x >= mask.width || y < 0 || y >= mask.height) continue;
        auto& cell = mask.coverage[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                                   static_cast<std::size_t>(x)];
        const int sum = cell + bitmap.buffer[row * bitmap.pitch + column];  // neighbours may share a pixel
        cell = static_cast<std::uint8_t>(std::min(sum, 255));
      }
    }
  });
  return mask;
}

Path Font::outline(std::string_view text) const {
  struct Pen {
    Path path;
    Corner at;
    double x = 0;
    Corner corner(const FT_Vector* point) const {
      return {x + static_cast<double>(point->x) / 64, -static_cast<double>(point->y) / 64};
    }
    void close() {
      if (!path.empty() && path.back().corners != 0) path.push_back({});
    }
  } pen;
  FT_Outline_Funcs steps = {};
  steps.move_to = [](const FT_Vector* to, void* user) {
    auto& p = *static_cast<Pen*>(user);
    p.close();
    p.at = p.corner(to);
    p.path.push_back({true, 1, {p.at}});
    return 0;
  };
  steps.line_to = [](const FT_Vector* to, void* user) {
    auto& p = *static_cast<Pen*>(user);
    p.at = p.corner(to);
    p.path.push_back({false, 1, {p.at}});
    return 0;
  };
  steps.conic_to = [](const FT_Vector* control, const FT_Vector* to, void* user) {
    // A parabola as a cubic: its control points lie two thirds of the way to the parabola's one.
    auto& p = *static_cast<Pen*>(user);
    const Corner c = p.corner(control), end = p.corner(to);
    const auto toward = [](const Corner& from, const Corner& other) {
      return Corner{from.x + 2.0 / 3 * (other.x - from.x), from.y + 2.0 / 3 * (other.y - from.y)};
    };
    p.path.push_back({false, 3, {toward(p.at, c), toward(end, c), end}});
    p.at = end;
    return 0;
  };
  steps.cubic_to = [](const FT_Vector* first, const FT_Vector* second, const FT_Vector* to, void* user) {
    auto& p = *static_cast<Pen*>(user);
    p.path.push_back({false, 3, {p.corner(first), p.corner(second), p.corner(to)}});
    p.at = p.corner(to);
    return 0;
  };
  face_->walk(text, [&](FT_GlyphSlot slot, double x) {
    pen.x = x;
    if (const FT_Error error = FT_Outline_Decompose(&slot->outline, &steps, &pen); error != 0) {
      fail(error, "trace a glyph of");
    }
    pen.close();
  });
  return std::move(pen.path);
}

CoverageMask Font::fill(const std::vector<Corner>& polygon, int width, int height) const {
  CoverageMask mask;
  mask.width = width;
  mask.height = height;
  mask.coverage.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::vector<FT_Vector> points;
  points.reserve(polygon.size());
  for (const Corner& corner : polygon) points.push_back({to_26_6(corner.x), to_26_6(height - corner.y)});
  // The numbers of an outline became unsigned in FreeType 2.13.3.
  FT_Outline outline = {};
  std::vector<std::remove_pointer_t<decltype(outline.tags)>> tags(points.size(), FT_CURVE_TAG_ON);
  auto last = static_cast<std::remove_pointer_t<decltype(outline.contours)>>(points.size() - 1);
  outline.n_contours = 1;
  outline.n_points = static_cast<decltype(outline.n_points)>(points.size());
  outline.points = points.data();
  outline.tags = tags.data();
  outline.contours = &last;
  FT_Bitmap bitmap = {};
  bitmap.rows = static_cast<unsigned>(height);
  bitmap.width = static_cast<unsigned>(width);
  bitmap.pitch = width;  // positive: rows from the top
  bitmap.buffer = mask.coverage.data();
  bitmap.num_grays = 256;
  bitmap.pixel_mode = FT_PIXEL_MODE_GRAY;
  if (const FT_Error error = FT_Outline_Get_Bitmap(face_->library, &outline, &bitmap); error != 0) {
    fail(error, "fill a polygon beside");
  }
  return mask;
}

std::optional<FontMatch> match_font(const std::string& name) {
  ProcessSpec process;
  const std::string begins = "granuscope takes ";  // a wrapper may print notes before
  process.arguments = {"fc-match", "--format=" + begins + "%{family}\n%{file}", "--", name};
  ProcessResult result;
  try {
    result = run_process(process);
  } catch (const EnvironmentError&) {
    return std::nullopt;
  }
  std::string said = result.standard_output;
  const std::size_t told = said.find(begins);
  if (result.exit_code != 0 || told == std::string::npos) return std::nullopt;
  said.erase(0, told + begins.size());
  const std::size_t line = said.find('\n');
  FontMatch match{said.substr(0, std::min(said.find(','), line)), said.substr(line + 1)};
  // Generic names stand for whatever is there.
  constexpr std::array generic = {"sans", "serif", "sans-serif", "monospace", "mono"};
  match.is_substitute = lower_case(said.substr(0, line)).find(lower_case(name)) == std::string::npos &&
                        std::ranges::find(generic, lower_case(name)) == generic.end();
  return match;
}

std::string typesetter() {
  FT_Library library = nullptr;
  if (const FT_Error error = FT_Init_FreeType(&library); error != 0) fail(error, "start for");
  FT_Int major = 0, minor = 0, patch = 0;
  FT_Library_Version(library, &major, &minor, &patch);
  FT_Done_FreeType(library);
  return fmt::format("FreeType {}.{}.{}", major, minor, patch);
}

CoverageMask turned_upwards(const CoverageMask& mask) {
  CoverageMask turned;
  turned.width = mask.height;
  turned.height = mask.width;
  turned.coverage.resize(mask.coverage.size());
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      turned.coverage[static_cast<std::size_t>(mask.width - 1 - x) * static_cast<std::size_t>(turned.width) +
                      static_cast<std::size_t>(y)] =
          mask.coverage[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                        static_cast<std::size_t>(x)];
    }
  }
  return turned;
}

}  // namespace granuscope
