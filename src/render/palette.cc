#include "render/palette.h"

#include <fmt/format.h>

#include <charconv>
#include <functional>
#include <optional>
#include <utility>

#include "support/error.h"
#include "support/template_file.h"

namespace granuscope {
namespace {

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::optional<Rgb> parse_colour(std::string_view word) {
  if (word.size() != 7 || word.front() != '#') return std::nullopt;
  std::uint32_t value = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data() + 1, end, value, 16);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return Rgb{static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8 & 0xff),
             static_cast<std::uint8_t>(value & 0xff)};
}

}  // namespace

const Palette& Palette::builtin() {
  static const Palette palette(template_file("palette.txt"), "templates/palette.txt");
  return palette;
}

Palette::Palette(std::string_view text, const std::string& source) : source_(source) {
  int number = 0;
  while (!text.empty()) {
    const auto end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    if (line.empty() || line.front() == '#') continue;

    const auto refuse = [&](const std::string& reason) {
      throw InputError(fmt::format("{}:{}: {}; a line reads `name = #rrggbb #rrggbb ...`", source, number, reason));
    };
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) refuse("no '=' between a name and its colours");
    const std::string name(trimmed(line.substr(0, equals)));
    if (name.empty()) refuse("no name before '='");
    std::vector<Rgb> colours;
    std::string_view rest = trimmed(line.substr(equals + 1));
    while (!rest.empty()) {
      const std::string_view word = rest.substr(0, rest.find_first_of(blanks));
      const auto colour = parse_colour(word);
      if (!colour) refuse(fmt::format("'{}' is not a colour", word));
      colours.push_back(*colour);
      rest = trimmed(rest.substr(word.size()));
    }
    if (colours.empty()) refuse(fmt::format("'{}' has no colour", name));
    if (!entries_.emplace(name, std::move(colours)).second) refuse(fmt::format("'{}' is given twice", name));
  }
}

const std::vector<Rgb>& Palette::colours(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end()) {
    std::string known;
    for (const auto& [key, value] : entries_) known += (known.empty() ? "" : ", ") + key;
    throw InputError(fmt::format("no colour is called '{}' in {}; it has {}", name, source_, known));
  }
  return found->second;
}

Rgb Palette::colour(const std::string& name) const {
  const auto& all = colours(name);
  if (all.size() != 1) {
    throw InputError(fmt::format("'{}' in {} has {} colours where one is needed", name, source_, all.size()));
  }
  return all.front();
}

std::string to_hex(Rgb colour) { return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b); }

}  // namespace granuscope
