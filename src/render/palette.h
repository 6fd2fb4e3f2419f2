#pragma once
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

}  // namespace granuscope
