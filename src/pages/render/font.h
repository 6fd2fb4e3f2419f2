#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {

/// How much of each pixel is covered, 0 .. 255, rows from the top.
struct CoverageMask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> coverage;
};

/// A corner of a polygon, pixels.
struct Corner {
  double x = 0, y = 0;
};

/// One step of an outline: to corner[0], which starts a new part or ends a line; or a cubic curve by two control points
/// to corner[2]; or, without corners, back to where the part started.
struct PathStep {
  bool starts = false;
  std::size_t corners = 0;  ///< 1, 3 or 0
  std::array<Corner, 3> corner{};
};
using Path = std::vector<PathStep>;

/// What fontconfig has under a name.
struct FontMatch {
  std::string family, file;
  bool is_substitute = false;  ///< of another name, because there is no such font here
};

/// Nothing where fontconfig's fc-match is missing, so that nobody can be asked.
std::optional<FontMatch> match_font(const std::string& name);

/// A font, DejaVu Sans if no file is named, at one size, in final pixels; DejaVu Sans has the signs that it lacks. And
/// a filler of polygons with the same rasteriser (exact coverage). Throws EnvironmentError if the font is not
/// installed.
class Font {
 public:
  explicit Font(double size_px, const std::string& file = "");
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;
  ~Font();

  /// Advance width of the UTF-8 text in whole pixels, rounded up.
  int width(std::string_view text) const;
  /// Height above and below the base line that no glyph of our labels leaves, whole pixels.
  int ascent() const;
  int descent() const;
  /// Height of a digit, to centre numbers on their ticks.
  double digit_height() const;
  /// The text in a box of width(text) x (ascent() + descent()).
  CoverageMask paint(std::string_view text) const;
  /// Its outlines, from the start of the base line, y downwards.
  Path outline(std::string_view text) const;
  /// Coverage of a closed polygon in a box of width x height pixels; corners count from its upper left one.
  CoverageMask fill(const std::vector<Corner>& polygon, int width, int height) const;

 private:
  struct Face;
  std::unique_ptr<Face> face_;
  double size_px_;
};

/// The library that renders the text, with its version; another one may round an edge of a letter otherwise.
std::string typesetter();

/// The mask turned by 90° counterclockwise: the text then reads upwards.
CoverageMask turned_upwards(const CoverageMask& mask);

}  // namespace granuscope
