#include "plot/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "support/axis_ticks.h"
#include "support/number_format.h"

namespace granuscope {

void Range::add(double number) {
  if (!std::isfinite(number)) return;
  low = empty ? number : std::min(low, number);
  high = empty ? number : std::max(high, number);
  empty = false;
}

std::string linear_ticks(const Range& range, int most) {
  if (!(range.size() > 0)) return fmt::format("'{:.6g}' {:.12g}", range.low, range.low);
  const RoundStep step = round_step_with_at_most(most, range.low, range.high);
  std::string list;
  for (const double mark : multiples_within(range.low, range.high, step)) {
    std::string label = fmt::format("{:.{}f}", std::abs(mark), std::max(0, -step.exponent));
    if (mark < 0) label.insert(0, "−");
    if (!list.empty()) list += ", ";
    list += fmt::format("'{}' {:.12g}", label, mark);
  }
  return list;
}

namespace {

/// "0.002", or "2 × 10⁻³": in plain letters, since WeasyPrint misplaces raised ones.
std::string log_label(const LogMark& mark, bool as_power) {
  if (!as_power) return fmt::format("{:.6g}", mark.value());
  return (mark.digit == 1 ? "" : fmt::format("{} × ", mark.digit)) + power_of_ten(mark.exponent);
}

}  // namespace

std::string log_ticks(const Range& range) {
  std::string list;
  int labels = 0;
  constexpr double smallest_plain = 1e-3, largest_plain = 9e4;
  const bool as_powers = range.low < smallest_plain * (1 - 1e-9) || range.high > largest_plain;
  const bool decades_only = std::floor(std::log10(range.high)) - std::ceil(std::log10(range.low)) >= 1;
  for (const LogMark& mark : log_marks_within(range.low, range.high)) {
    const bool labelled = mark.digit == 1 || (!decades_only && (mark.digit == 2 || mark.digit == 5));
    if (labelled) ++labels;
    if (!list.empty()) list += ", ";
    list += labelled ? fmt::format("'{}' {:.6g} 0", log_label(mark, as_powers), mark.value())
                     : fmt::format("'' {:.6g} 1", mark.value());
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
  constexpr double font_points = 9, plot_points = 6.69 * 72;
  constexpr double left_for_labels = 0.062;
  double widest = 0;
  for (const std::string& ticks : tick_lists) {
    for (std::size_t from = ticks.find('\''); from != std::string::npos; from = ticks.find('\'', from + 1)) {
      const std::size_t to = ticks.find('\'', from + 1);
      widest = std::max(widest, width_in_ems(ticks.substr(from + 1, to - from - 1)));
      from = to;
    }
  }
  return std::max(0.0, widest * font_points / plot_points - left_for_labels);
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

}  // namespace granuscope
