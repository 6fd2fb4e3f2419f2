// What the page of a run shows depth by depth (templates/explore.html, templates/report.js): the response at every
// recorded depth with its fit, as whole numbers of a small unit.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "model/lattice.h"
#include "report/number_text.h"
#include "report/page_overlays.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
/// A page has room for half a megabyte of points, seven bytes each. Beyond them depths are left out, and beads of one.
constexpr std::size_t most_points = 65'000, most_points_of_a_depth = 160;

/// Beads on the right of the overload, as far as anything of the response arrives: no peak is faster than without
/// friction. The left half of a profile mirrors them.
std::vector<std::size_t> shown_beads(const ResponseProfile& profile, const DepthFit& fit) {
  const double reach = profile.c0 * profile.z + 5 * (fit.width.known() ? fit.width.value : 1) + 5;
  std::vector<std::size_t> beads;
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    if (profile.x[i] >= 0 && profile.x[i] <= reach) beads.push_back(i);
  }
  const std::size_t step = (beads.size() + most_points_of_a_depth - 1) / most_points_of_a_depth;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < beads.size(); i += step) some.push_back(beads[i]);
  return some;
}

/// A power of ten of which the median standard error has two digits; 0 where a profile is exact.
double unit_of(const Transport& result) {
  std::vector<double> errors;
  for (const ResponseProfile& profile : result.profiles) {
    std::copy_if(profile.standard_error.begin(), profile.standard_error.end(), std::back_inserter(errors),
                 [](double error) { return error > 0; });
  }
  if (errors.empty()) return 0;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return std::pow(10, std::floor(std::log10(*middle)) - 1);
}

Json text_of(const Estimate& number) {
  return number.known() ? Json(plain_value_with_error(number.value, number.standard_error)) : Json(nullptr);
}

Json depth_of(const ResponseProfile& profile, const DepthFit& fit, double unit) {
  Json pressures = Json::array(), errors = Json::array();
  const std::vector<std::size_t> beads = shown_beads(profile, fit);
  for (const std::size_t i : beads) {
    pressures.push_back(std::llround(profile.pressure[i] / unit));
    errors.push_back(std::llround(profile.standard_error[i] / unit));
  }
  const double first = beads.empty() ? 0 : profile.x[beads[0]];
  const double step = beads.size() < 2 ? 1 : profile.x[beads[1]] - first;
  const bool fitted = fit.identifiable && fit.degrees_of_freedom > 0;
  Json depth = {{"layer", fit.layer},
                {"z", format_number(fit.z, "fixed 2")},
                {"x_p", fit.identifiable ? text_of(fit.peak_position) : Json(nullptr)},
                {"W", fit.identifiable ? text_of(fit.width) : Json(nullptr)},
                {"chi2", fitted ? Json(format_number(fit.chi2_per_dof, "fixed 2")) : Json(nullptr)},
                {"dof", fit.degrees_of_freedom},
                {"x", {first, step}},
                {"P", pressures},
                {"error", errors}};
  if (!fitted) depth["reason"] = clean_text(fit.reason);
  return depth;
}

Json depths_of(const Transport& result, double unit, std::size_t step) {
  Json depths = Json::array();
  for (std::size_t i = 0; i < result.profiles.size(); i += step) {
    const ResponseProfile& profile = result.profiles[i];
    for (const DepthFit& fit : result.depths) {
      if (fit.layer == profile.layer) depths.push_back(depth_of(profile, fit, unit));
    }
  }
  return depths;
}

}  // namespace

void add_explored_depths(Json& overlay, const Analysis& analysis) {
  std::size_t points = 0;
  for (const Transport& result : analysis.results) {
    for (const ResponseProfile& profile : result.profiles) {
      for (const DepthFit& fit : result.depths) {
        if (fit.layer == profile.layer) points += shown_beads(profile, fit).size();
      }
    }
  }
  Json data = Json::array();
  for (const Transport& result : analysis.results) {
    const double unit = unit_of(result);
    if (result.exact || unit == 0) continue;  // rounding is no scatter
    const auto line = [](const Estimate& slope, const Estimate& offset) {
      return slope.known() && offset.known() ? Json{offset.value, slope.value} : Json(nullptr);
    };
    data.push_back({{"scanned", format_number(result.scanned())},
                    {"c", text_of(result.c)},
                    {"D", text_of(result.D)},
                    {"position", line(result.c, result.position_offset)},
                    {"square", line(result.D, result.width_offset)},
                    {"window", result.window_layers},
                    {"unit", unit},
                    {"depths", depths_of(result, unit, 1 + points / most_points)}});
  }
  std::string text = data.dump();
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");  // nothing in it ends the element in which it stands
  }
  overlay["explored"] =
      data.empty()
          ? Json(nullptr)
          : Json{{"data", text}, {"symbol", analysis.scan->symbol}, {"figures_of_mu", analysis.scan->symbol == "μ"}};
}

}  // namespace granuscope
