#include "analysis/fit_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace granuscope {
namespace {

Problem find_window_problem(const char* field, const std::array<double, 2>& window) {
  if (window[0] < window[1]) return {};
  return problem(field, "[{}, {}] is not a range of mu: it must ascend from 0 or more; write [low, high]", window[0],
                 window[1]);
}

}  // namespace

std::vector<Key> keys_of(FitSpec& spec) {
  const std::string table = "fit";
  return {
      make_key(table, "first_layer", "layer", "first layer of the window over which the slopes c and D are taken",
               spec.first_layer, KeyRange{.least = 0}),
      make_key(table, "last_layer", "layer", "last layer of that window, at most lattice.layers - 21", spec.last_layer,
               KeyRange{.least = 0}),
      make_key(table, "layer_step", "layers",
               "distance of the fitted layers; an odd one alternates the two kinds of rows", spec.layer_step,
               KeyRange{.least = 1, .why = "it would never reach the end of the window"}),
      make_key(table, "shallow_layer", "layer", "from here down to the window layers are fitted for the figures only",
               spec.shallow_layer, KeyRange{.least = 0}),
      make_key(
          table, "min_identifiable_width", "bead diameters", "below it the size of a bead hides the width of a peak",
          spec.min_identifiable_width,
          KeyRange{.why = "below about half a bead the width of a peak cannot be told from the bead's (0.5 is usual)"}
              .within(least_identifiable_width, 100)),
      make_key(table, "scaling_window", "",
               "range of mu, or of what is scanned, both ends included, of the exponents beta, gamma and alpha",
               spec.scaling_window, KeyRange{.least = 0}),
      make_key(table, "other_scaling_windows", "", "further ranges of mu whose exponents are shown beside it",
               spec.other_scaling_windows, KeyRange{.least = 0}),
  };
}

bool at_step(const FitSpec& spec, int layer) {
  return layer <= spec.last_layer && (spec.last_layer - layer) % spec.layer_step == 0;
}
bool in_window(const FitSpec& spec, int layer) { return layer >= spec.first_layer && at_step(spec, layer); }

Problem find_problem(const FitSpec& fit, const LatticeSpec& lattice, int unused) {
  const int last_usable = lattice.layers - unused - 1;
  FitSpec copy = fit;  // keys could set what they check
  if (auto found = find_range_problem(keys_of(copy))) return found;
  if (fit.shallow_layer > fit.first_layer) {
    return problem("shallow_layer", "layer {} must lie between 0 and first_layer = {}", fit.shallow_layer,
                   fit.first_layer);
  }
  if (fit.last_layer > last_usable) {
    return problem("last_layer",
                   "layer {} lies beyond the last usable one, {}: the lowest {} of {} layers "
                   "follow another law; end the window at {} or compute {} layers",
                   fit.last_layer, last_usable, unused, lattice.layers, last_usable,
                   static_cast<std::int64_t>(fit.last_layer) + unused + 1);
  }
  const int depths = fit.last_layer < fit.first_layer ? 0 : 1 + (fit.last_layer - fit.first_layer) / fit.layer_step;
  if (depths < least_window_depths) {
    constexpr int steps = least_window_depths - 1;
    const std::int64_t first = fit.last_layer - std::int64_t{steps} * fit.layer_step;
    const int step = (fit.last_layer - fit.first_layer) / steps;
    return problem(step > 0 ? "layer_step" : "first_layer",
                   "the window from layer {} to {} in steps of {} holds {} depth{}, but a slope with "
                   "a test of it needs {}; {}{}",
                   fit.first_layer, fit.last_layer, fit.layer_step, depths, depths == 1 ? "" : "s", least_window_depths,
                   step > 0 ? fmt::format("take steps of at most {}, or ", step) : "",
                   first >= fit.shallow_layer ? fmt::format("begin it at layer {}", first) : "end it deeper");
  }
  if (auto found = find_window_problem("scaling_window", fit.scaling_window)) return found;
  for (const auto& window : fit.other_scaling_windows) {
    if (auto found = find_window_problem("other_scaling_windows", window)) return found;
  }
  return {};
}

std::vector<std::size_t> identifiable_depths(std::span<const DepthUse> depths) {
  std::vector<std::size_t> run;
  for (std::size_t i = depths.size(); i-- > 0;) {
    if (depths[i] == DepthUse::fitted) {
      run.push_back(i);
      continue;
    }
    const bool deeper_was_used = i + 1 == depths.size() || depths[i + 1] == DepthUse::fitted;
    if (depths[i] == DepthUse::unidentified || !deeper_was_used) break;
  }
  std::ranges::reverse(run);
  return run;
}

}  // namespace granuscope
