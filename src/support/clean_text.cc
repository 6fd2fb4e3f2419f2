#include "support/clean_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include <cstddef>

namespace granuscope {

namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";  // U+FFFD

bool continues(std::string_view text, std::size_t at) {
  return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
}

/// Length of the well-formed multi-byte character at the start of `text`, or 0 (Unicode 15, table 3-7: no overlong
/// forms, no surrogates, nothing beyond U+10FFFF).
std::size_t character_length(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (!continues(text, 1)) return 0;
  const auto second = static_cast<unsigned char>(text[1]);
  if (first >= 0xC2 && first <= 0xDF) return 2;
  if (!continues(text, 2)) return 0;
  if (first == 0xE0) return second >= 0xA0 ? 3 : 0;
  if (first == 0xED) return second <= 0x9F ? 3 : 0;
  if (first > 0xE0 && first <= 0xEF) {
    const bool noncharacter = first == 0xEF && second == 0xBF && static_cast<unsigned char>(text[2]) >= 0xBE;
    return noncharacter ? 0 : 3;  // U+FFFE and U+FFFF are not allowed in XML
  }
  if (!continues(text, 3)) return 0;
  if (first == 0xF0) return second >= 0x90 ? 4 : 0;
  if (first == 0xF4) return second <= 0x8F ? 4 : 0;
  return first > 0xF0 && first < 0xF4 ? 4 : 0;
}

}  // namespace

std::string clean_text(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size());
  for (std::size_t at = 0; at < bytes.size();) {
    const auto byte = static_cast<unsigned char>(bytes[at]);
    if (byte >= 0x80) {
      const std::size_t length = character_length(bytes.substr(at));
      // U+0080 to U+009F are control characters too.
      const bool control = length == 2 && byte == 0xC2 && static_cast<unsigned char>(bytes[at + 1]) < 0xA0;
      text += length == 0 || control ? replacement : bytes.substr(at, length);
      at += length == 0 ? 1 : length;
      continue;
    }
    if (byte == '\r') {
      if (at + 1 >= bytes.size() || bytes[at + 1] != '\n') text += '\n';
    } else if ((byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F) {
      text += replacement;
    } else {
      text += bytes[at];
    }
    ++at;
  }
  return text;
}

std::string escape_markup(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string pdf_string(std::string_view bytes) {
  const std::string text = clean_text(bytes);
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (plain) {
    std::string string = "(";
    for (const char c : text) {
      if (c == '(' || c == ')' || c == '\\') string += '\\';
      string += c;
    }
    return string + ")";
  }
  std::string string = "<FEFF";
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const int more = first < 0x80U ? 0 : first < 0xE0U ? 1 : first < 0xF0U ? 2 : 3;
    std::uint32_t code = more == 0 ? first : first & (0x3FU >> static_cast<unsigned>(more));
    for (int k = 1; k <= more; ++k) {
      code = (code << 6U) | (static_cast<unsigned char>(text[i + static_cast<std::size_t>(k)]) & 0x3FU);
    }
    i += static_cast<std::size_t>(more) + 1;
    if (code >= 0x10000U) {
      code -= 0x10000U;
      string += fmt::format("{:04X}", 0xD800U + (code >> 10U));
      code = 0xDC00U + (code & 0x3FFU);
    }
    string += fmt::format("{:04X}", code);
  }
  return string + ">";
}

}  // namespace granuscope
