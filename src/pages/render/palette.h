#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {
/// One sRGB colour, 8 bits a channel.
struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

/// Named colours and colour maps, read from lines `name = #rrggbb #rrggbb ...`. Empty lines and lines that start with #
/// are passed over.
class Palette {
 public:
  /// The palette of the program, templates/palette.txt.
  static const Palette& builtin();
  /// Reads `text`; `source` is its name in messages. Throws InputError naming the line: no '=', an empty or repeated
  /// name, no colour, a colour that is not #rrggbb.
  Palette(std::string_view text, const std::string& source);

  /// All colours of an entry: the anchors of a map, or a list of categories. Throws InputError with the known names.
  const std::vector<Rgb>& colours(const std::string& name) const;
  /// The only colour of an entry. Throws InputError if it holds several.
  Rgb colour(const std::string& name) const;

 private:
  std::string source_;
  std::map<std::string, std::vector<Rgb>, std::less<>> entries_;
};

/// "#rrggbb", as plotting programs read it.
std::string to_hex(Rgb colour);

enum class Sign { one, both };

/// The scale of a scene: values as levels, whole numbers that fit a byte. One-signed: level 0 at `low` and below,
/// most_levels at `high` and above. Both signs (low = -high): twice the steps from 0, the last bit telling the
/// negative ones, so that the stronger one has the higher level.
struct ValueScale {
  double low = 0, high = 1;
  Sign sign = Sign::one;
  int most_levels = 255;  ///< fewer if levels are kept for lines over the picture
  int disc_level = -1;    ///< of discs that stand for particles, not for values; -1: there are none

  std::uint8_t level(double value) const;
  /// -1 .. 1: the place of a level on the scale.
  double strength(std::uint8_t level) const;
};

/// The ends of a scale that somebody asked for. Throws InputError unless they are numbers in ascending order, and for
/// both signs symmetric about 0.
std::array<double, 2> checked_range(const std::array<double, 2>& range, Sign sign);

/// How values are distributed, at a relative resolution of 2^-9 and in memory that does not grow with their number.
class MagnitudeHistogram {
 public:
  MagnitudeHistogram();
  void add(double magnitude);  ///< finite, at least 0
  /// A number that at least this share of the magnitudes do not exceed; 0 if there are none.
  double quantile(double share) const;

 private:
  std::vector<std::uint64_t> counts_;
  std::uint64_t total_ = 0;
};

/// The next number upwards at which a scale ends well: 1, 1.2, 1.5, ... times a power of ten.
double round_up(double value);

/// Colours of the strengths of a scale on the page. One-signed: the page itself at 0, darker and darker up to 1; a map
/// that is known from dark to light is turned around, and one that does not start at the colour of the page gets the
/// page as a first anchor; so nothing shows nothing, and darkness is monotone. Both signs: a map from -1 to 1 whose
/// middle is the page.
class ColourScale {
 public:
  /// Throws InputError unless `map` is one of the palette's maps for this kind: grey, viridis, cividis, or diverging.
  ColourScale(const Palette& palette, const std::string& map, Sign sign = Sign::one);

  Rgb page() const { return page_; }
  /// Colour of strength 0 .. 1 or -1 .. 1 (beyond: the end), where a share `ink` (0 .. 1) of the page is covered by it.
  Rgb at(double strength, double ink = 1) const;

 private:
  Rgb page_;
  Sign sign_;
  std::vector<std::array<double, 3>> anchors_;
};

}  // namespace granuscope
