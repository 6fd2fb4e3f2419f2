#include "plot/choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/number_format.h"

namespace granuscope {

const Transport* nearest_result(const std::vector<Transport>& results, double mu,
                                const std::function<bool(const Transport&)>& usable) {
  const Transport* nearest = nullptr;
  for (const Transport& result : results) {
    if (!usable(result)) continue;
    if (nearest == nullptr || std::abs(result.mu() - mu) < std::abs(nearest->mu() - mu)) nearest = &result;
  }
  return nearest;
}

void Range::add(double number) {
  if (!std::isfinite(number)) return;
  low = empty ? number : std::min(low, number);
  high = empty ? number : std::max(high, number);
  empty = false;
}

std::string linear_ticks(const Range& range, int most) {
  if (!(range.size() > 0)) return fmt::format("'{:.6g}' {:.12g}", range.low, range.low);
  // The smallest of 1, 2, 5 times a power of ten that gives few enough marks.
  int exponent = static_cast<int>(std::floor(std::log10(range.size() / most))) - 1;
  int digit = 1;
  const auto step = [&] { return digit * std::pow(10, exponent); };
  constexpr double rounding = 1e-9;
  const auto first = [&] { return std::ceil(range.low / step() - rounding); };
  const auto last = [&] { return std::floor(range.high / step() + rounding); };
  while (last() - first() + 1 > most) {
    digit = digit == 1 ? 2 : digit == 2 ? 5 : 1;
    if (digit == 1) ++exponent;
  }
  std::string list;
  const auto marks = static_cast<int>(last() - first());
  for (int i = 0; i <= marks; ++i) {
    const double multiple = first() + i;
    const double mark = multiple == 0 ? 0 : multiple * step();
    std::string label = fmt::format("{:.{}f}", std::abs(mark), std::max(0, -exponent));
    if (mark < 0) label.insert(0, "−");
    if (!list.empty()) list += ", ";
    list += fmt::format("'{}' {:.12g}", label, mark);
  }
  return list;
}

namespace {

/// "0.002", or "2 × 10⁻³": in plain letters, since WeasyPrint misplaces raised ones.
std::string log_label(int digit, int exponent, bool as_power) {
  if (!as_power) return fmt::format("{:.6g}", digit * std::pow(10, exponent));
  return (digit == 1 ? "" : fmt::format("{} × ", digit)) + power_of_ten(exponent);
}

}  // namespace

std::string log_ticks(const Range& range) {
  std::string list;
  int labels = 0;
  constexpr double smallest_plain = 1e-3, largest_plain = 9e4;
  const bool as_powers = range.low < smallest_plain * (1 - 1e-9) || range.high > largest_plain;
  const bool decades_only = std::floor(std::log10(range.high)) - std::ceil(std::log10(range.low)) >= 1;
  for (int exponent = static_cast<int>(std::floor(std::log10(range.low))); std::pow(10, exponent) <= range.high;
       ++exponent) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double mark = digit * std::pow(10, exponent);
      if (mark < range.low * (1 - 1e-9) || mark > range.high * (1 + 1e-9)) continue;
      const bool labelled = digit == 1 || (!decades_only && (digit == 2 || digit == 5));
      if (labelled) ++labels;
      if (!list.empty()) list += ", ";
      list += labelled ? fmt::format("'{}' {:.6g} 0", log_label(digit, exponent, as_powers), mark)
                       : fmt::format("'' {:.6g} 1", mark);
    }
  }
  // So short an axis reads better with even steps.
  return labels < 2 ? linear_ticks(range, 4) : list;
}

std::string three_ticks(double reach) {
  const double power = std::pow(10, std::floor(std::log10(reach)));
  const double mark = power * (reach >= 5 * power ? 5 : reach >= 2 * power ? 2 : 1);
  return fmt::format("'−{0:.6g}' -{0:.6g}, '0' 0, '{0:.6g}' {0:.6g}", mark);
}

namespace {

/// Width of a label in units of the font's size, in DejaVu Sans.
double width_in_ems(const std::string& label) {
  double width = 0;
  for (std::size_t i = 0; i < label.size(); ++i) {
    const auto byte = static_cast<unsigned char>(label[i]);
    if ((byte & 0xC0U) == 0x80U) continue;  // a later byte of a letter
    const bool sign = label.compare(i, 3, "−") == 0 || label.compare(i, 2, "×") == 0;
    width += byte == '.' || byte == ' ' ? 0.32 : sign ? 0.84 : byte < 0x80U ? 0.64 : 0.43;
  }
  return width;
}

}  // namespace

double room_for_labels(const std::vector<std::string>& tick_lists) {
  constexpr double font_points = 9, drawing_points = 6.69 * 72;
  constexpr double left_for_labels = 0.062;
  double widest = 0;
  for (const std::string& ticks : tick_lists) {
    for (std::size_t from = ticks.find('\''); from != std::string::npos; from = ticks.find('\'', from + 1)) {
      const std::size_t to = ticks.find('\'', from + 1);
      widest = std::max(widest, width_in_ems(ticks.substr(from + 1, to - from - 1)));
      from = to;
    }
  }
  return std::max(0.0, widest * font_points / drawing_points - left_for_labels);
}

std::string without_labels(const std::string& ticks) {
  std::string bare;
  bool inside = false;
  for (const char letter : ticks) {
    if (letter == '\'') {
      inside = !inside;
      bare += letter;
    } else if (!inside) {
      bare += letter;
    }
  }
  return bare;
}

Range widened_by_factor(const Range& range, double factor) {
  Range wider = range;
  wider.low /= factor;
  wider.high *= factor;
  return wider;
}

bool in_window(double mu, const std::array<double, 2>& window) {
  constexpr double rounding = 1e-9;
  return mu >= window[0] - rounding && mu <= window[1] + rounding;
}

Analysis without_vague_points(const Analysis& analysis) {
  // Half of D still is a point on logarithmic axes; c is known to parts in a thousand wherever it means something.
  constexpr double vague_D = 0.5, vague_c = 0.05;
  const auto drop_if_vague = [](Estimate& estimate, double share) {
    if (!estimate.known()) estimate.reason = "why stands under the table of c and D";
    if (!estimate.known() || estimate.standard_error <= share * std::abs(estimate.value)) return;
    estimate.reason =
        fmt::format("too uncertain for a point: {}", value_with_error(estimate.value, estimate.standard_error));
    estimate.value = estimate.standard_error = std::numeric_limits<double>::quiet_NaN();
  };
  Analysis clear = analysis;
  for (Transport& result : clear.results) {
    drop_if_vague(result.c, vague_c);
    drop_if_vague(result.D, vague_D);
  }
  return clear;
}

}  // namespace granuscope
