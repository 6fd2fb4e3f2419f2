#include "render/palette.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "support/error.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {
namespace {

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
      throw InputError("{}:{}: {}; a line reads `name = #rrggbb #rrggbb ...`", source, number, reason);
    };
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) refuse("no '=' between a name and its colours");
    const std::string name(trimmed(line.substr(0, equals)));
    if (name.empty()) refuse("no name before '='");
    std::vector<Rgb> colours;
    std::string_view rest = trimmed(line.substr(equals + 1));
    while (!rest.empty()) {
      const std::string_view word = rest.substr(0, rest.find_first_of(" \t"));
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
    throw InputError("no colour is called '{}' in {}; it has {}", name, source_, known);
  }
  return found->second;
}

Rgb Palette::colour(const std::string& name) const {
  const auto& all = colours(name);
  if (all.size() != 1) throw InputError("'{}' in {} has {} colours where one is needed", name, source_, all.size());
  return all.front();
}

std::string to_hex(Rgb colour) { return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b); }

namespace {

/// Luminance of ITU-R BT.709 on the sRGB values as they are: only the order of two colours matters here.
double lightness(Rgb colour) { return 0.2126 * colour.r + 0.7152 * colour.g + 0.0722 * colour.b; }

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

std::vector<Rgb> anchors_of(const Palette& palette, const std::string& map, Sign sign, Rgb page) {
  const bool one_signed = map == "grey" || map == "viridis" || map == "cividis";
  if (sign == Sign::one && !one_signed) {
    throw InputError(
        "'{}' is not a colour map for a quantity of one sign, as this scene shows; choose grey, viridis or cividis",
        map);
  }
  if (sign == Sign::both && map != "diverging") {
    throw InputError("'{}' is not a colour map for a quantity of both signs, as this scene shows; choose diverging",
                     map);
  }
  std::vector<Rgb> colours = palette.colours(map);
  if (sign == Sign::both) {
    if (colours.size() % 2 == 0 || colours[colours.size() / 2] != page) {
      throw std::logic_error("palette.txt: the middle of the diverging map is not the page");
    }
    return colours;
  }
  if (lightness(colours.front()) < lightness(colours.back())) std::ranges::reverse(colours);
  if (colours.front() != page) colours.insert(colours.begin(), page);
  return colours;
}

}  // namespace

ColourScale::ColourScale(const Palette& palette, const std::string& map, Sign sign)
    : page_(palette.colour("page")), sign_(sign) {
  for (const Rgb colour : anchors_of(palette, map, sign, page_)) {
    anchors_.push_back({static_cast<double>(colour.r), static_cast<double>(colour.g), static_cast<double>(colour.b)});
  }
}

Rgb ColourScale::at(double strength, double ink) const {
  const double place = sign_ == Sign::one ? strength : 0.5 * (strength + 1);
  const double position = std::clamp(place, 0.0, 1.0) * static_cast<double>(anchors_.size() - 1);
  const std::size_t lower = std::min(static_cast<std::size_t>(position), anchors_.size() - 2);
  const double share = position - static_cast<double>(lower);
  const std::array<double, 3> page{static_cast<double>(page_.r), static_cast<double>(page_.g),
                                   static_cast<double>(page_.b)};
  std::array<double, 3> value{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double full = anchors_[lower][c] + share * (anchors_[lower + 1][c] - anchors_[lower][c]);
    value[c] = page[c] + std::clamp(ink, 0.0, 1.0) * (full - page[c]);
  }
  return {to_byte(value[0]), to_byte(value[1]), to_byte(value[2])};
}

namespace {

/// Leading bits of a single-precision number (no sign: magnitudes) that choose its bin: exponent and 9 of mantissa.
constexpr unsigned mantissa_bits_dropped = 23 - 9;
constexpr std::size_t bins = std::size_t{1} << (31 - mantissa_bits_dropped);

/// Ends of a scale that divide into few round steps.
constexpr std::array<double, 14> round_ends = {1, 1.2, 1.5, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 5, 6, 8, 10};

}  // namespace

std::uint8_t ValueScale::level(double value) const {
  if (sign == Sign::one) {
    const double strength = std::clamp((value - low) / (high - low), 0.0, 1.0);
    // Not lround, whose call would take longer than all the rest; nothing here is negative or near the limit of a byte.
    return static_cast<std::uint8_t>(strength * most_levels + 0.5);  // NOLINT(bugprone-incorrect-roundings)
  }
  const double steps = (most_levels - 1) / 2;  // NOLINT(bugprone-integer-division): whole steps are meant
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): as above
  const auto step = static_cast<int>(std::min(std::abs(value) / high, 1.0) * steps + 0.5);
  return static_cast<std::uint8_t>(step == 0 ? 0 : 2 * step + (value < 0 ? 1 : 0));
}

double ValueScale::strength(std::uint8_t level) const {
  if (sign == Sign::one) return static_cast<double>(level) / most_levels;
  const int steps = (most_levels - 1) / 2;
  const int step = level / 2;
  const double magnitude = static_cast<double>(step) / steps;
  return level % 2 == 1 ? -magnitude : magnitude;
}

std::array<double, 2> checked_range(const std::array<double, 2>& range, Sign sign) {
  const std::string given = fmt::format("the range {},{} of the colour scale", range[0], range[1]);
  if (!std::isfinite(range[0]) || !std::isfinite(range[1]) || !std::isfinite(range[1] - range[0])) {
    throw InputError(given + " is not made of numbers; give LOW,HIGH in units of what the scene shows");
  }
  if (!(range[0] < range[1])) throw InputError(given + " is empty, so all would look alike; it needs LOW < HIGH");
  if (sign == Sign::both && range[0] != -range[1]) {
    throw InputError(given + " is not symmetric, but the middle of a diverging map means 0; give -X,X");
  }
  return range;
}

MagnitudeHistogram::MagnitudeHistogram() : counts_(bins) {}

void MagnitudeHistogram::add(double magnitude) {
  ++counts_[std::bit_cast<std::uint32_t>(static_cast<float>(magnitude)) >> mantissa_bits_dropped];
  ++total_;
}

double MagnitudeHistogram::quantile(double share) const {
  const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(total_));
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    below += counts_[bin];
    if (below == 0 || below < wanted) continue;
    // The bin's upper end, unless it holds nothing but zeros.
    return bin == 0 ? 0 : std::bit_cast<float>(static_cast<std::uint32_t>(bin + 1) << mantissa_bits_dropped);
  }
  return 0;
}

double round_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  // A histogram tells a value to 2^-9 only; a scale that ends so little below it is as good.
  constexpr double slack = 1.0 / 256;
  for (const double end : round_ends) {
    if (end * power >= value * (1 - slack)) return end * power;
  }
  return 10 * power;
}

}  // namespace granuscope
