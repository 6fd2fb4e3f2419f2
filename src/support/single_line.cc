#include "support/single_line.h"

namespace granuscope {
namespace {

bool continues_a_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

}  // namespace

std::string single_line(std::string_view text, std::size_t most) {
  std::string line;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (line.size() >= most && !continues_a_character(text[at])) return line + " …";
    const auto byte = static_cast<unsigned char>(text[at]);
    const bool control = byte < 0x20 || byte == 0x7F;
    // U+0080 to U+009F are control characters too, written as C2 80 to C2 9F.
    const bool control_of_two_bytes = byte == 0xC2 && at + 1 < text.size() && continues_a_character(text[at + 1]) &&
                                      static_cast<unsigned char>(text[at + 1]) < 0xA0;
    if (!control && !control_of_two_bytes) {
      line += text[at];
      continue;
    }
    if (control_of_two_bytes) ++at;
    if (!line.empty() && line.back() != ' ') line += ' ';
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace granuscope
