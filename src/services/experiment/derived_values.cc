#include "experiment/derived_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "ensemble/estimator.h"

namespace granuscope {
namespace {

const FitSpec usual_fit;
const FigureSpec usual_figures;

/// The nearest of these to `wanted` that has friction; 0 if none has.
double nearest_with_friction(const std::vector<double>& mu, double wanted) {
  double nearest = 0;
  for (const double one : mu) {
    if (one > 0 && (nearest == 0 || std::abs(one - wanted) < std::abs(nearest - wanted))) nearest = one;
  }
  return nearest;
}

/// Of a window over so many layers: odd, for some forty depths, and less where there would be hardly any.
int handy_step(int span) {
  constexpr int depths = 40, fewest = 6;
  if (span / usual_fit.layer_step + 1 < fewest) return 1;
  return std::max(usual_fit.layer_step, (span / depths - 1) | 1);
}

class Derivation {
 public:
  Derivation(Experiment& experiment, const std::set<std::string>& written)
      : e_(experiment), fit_(experiment.fit), written_(written) {}

  void go() {
    derive_friction();
    derive_samples();
    derive_three_leg();
    derive_lattice();
    derive_picture();
    for (const auto& study : e_.studies) {
      if (study->asked()) study->derive(e_, [this](const std::string& key) { return open(key); });
    }
  }

 private:
  bool open(const std::string& key) const { return !written_.contains(key); }

  bool of_friction() const { return &e_.scanned() == &friction_parameter(); }
  bool by_fluctuation() const { return e_.response.estimator == EstimatorName::fluctuation; }
  int margin() const { return bottom_margin_of(e_.sampling.model); }

  void derive_friction() {
    double& shown = e_.figures.profile_mu;
    const bool shown_open = open("figures.response_profiles.mu");
    if (open("friction.mu") && !of_friction() && e_.sampling.model.has_contacts()) e_.mu = {usual_figures.profile_mu};
    if (open("friction.mu") && !shown_open && of_friction() && std::ranges::count(e_.mu, shown) == 0) {
      e_.mu.insert(std::ranges::upper_bound(e_.mu, shown), shown);
    }
    if (shown_open && of_friction()) shown = nearest_with_friction(e_.mu, usual_figures.profile_mu);
    std::vector<double> values = e_.scan_values();
    std::erase(values, 0.0);
    const auto inside =
        std::ranges::count_if(values, [first = usual_fit.scaling_window[0], last = usual_fit.scaling_window[1]](
                                          double one) { return first <= one && one <= last; });
    constexpr int fewest = 3;  // an exponent with a test of it
    const bool of_other_scan = !of_friction() && values.size() > 1;
    if (open("fit.scaling_window") && (of_other_scan || (inside < fewest && std::ssize(values) >= fewest))) {
      fit_.scaling_window = {values.front(), values.back()};
    }
  }

  void derive_samples() {
    ResponseSpec& response = e_.response;
    const bool samples_open = open("response.samples");
    if (open("response.blocks") && !samples_open) {
      const std::uint64_t groups = response.samples / group_size;
      response.blocks = static_cast<int>(
          std::clamp<std::uint64_t>(groups, min_blocks, static_cast<std::uint64_t>(ResponseSpec{}.blocks)));
    }
    if (samples_open) {
      if (!open("precision.most_samples")) response.samples = std::min(response.samples, e_.precision.most_samples);
      response.samples = std::max(response.samples, group_size * static_cast<std::uint64_t>(response.blocks));
    }
    if (open("precision.most_samples"))
      e_.precision.most_samples = std::max(e_.precision.most_samples, response.samples);
  }

  /// A share of the middle leg that stays within [0, 1].
  void derive_three_leg() {
    ThreeLegSpec& legs = e_.sampling.model.three_leg;
    if (e_.sampling.model.name != ModelName::three_leg) return;
    const auto values = [&](const char* name, double one) {
      return e_.scanned().name == name ? e_.scan_values() : std::vector{one};
    };
    if (open("model.three_leg.middle")) legs.middle = std::max(legs.middle, values("noise", legs.noise).back());
    if (!open("model.three_leg.noise")) return;
    for (const double middle : values("middle", legs.middle))
      legs.noise = std::max(0.0, std::min({legs.noise, middle, 1 - middle}));
  }

  // The lattice and the window
  // -----------------------------------------------------------------------------------------

  /// Of a pile that the law or the model can solve.
  double most_beads() const {
    if (e_.sampling.model.name == ModelName::diluted_beads) return most_diluted_beads;
    if (!e_.sampling.model.is_beads()) return std::numeric_limits<double>::infinity();
    if (e_.sampling.law == Law::polytope) return static_cast<double>(most_polytope_beads);
    return e_.sampling.law == Law::rejection ? most_beads_by_rejection : std::numeric_limits<double>::infinity();
  }

  /// What is drawn where nothing else is known.
  LatticeSpec usual_lattice() const {
    if (e_.sampling.model.name == ModelName::diluted_beads) return {32, 20};
    if (!std::isfinite(most_beads())) return {};
    return e_.sampling.law == Law::polytope ? LatticeSpec{60, 60} : LatticeSpec{10, bottom_margin + 4};
  }

  /// Columns in which the model's noise is the same: those of a pile are a multiple.
  int cell() const {
    const ModelSpec& model = e_.sampling.model;
    if (model.name == ModelName::three_leg) return model.three_leg.cell_columns;
    return model.name == ModelName::stochastic_osl ? model.stochastic_osl.cell_columns : 1;
  }

  /// The columns that a file which names none may have in piles of so many layers.
  double columns_available() const {
    return open("lattice.columns") ? most_beads() / e_.lattice.layers : e_.lattice.columns;
  }

  int deepest_used() const {
    const bool profiles = e_.figures.response_profiles && !e_.figures.profile_layers.empty();
    return profiles ? std::max(fit_.last_layer, e_.figures.profile_layers.back()) : fit_.last_layer;
  }

  double columns_wanted() const {
    double most = std::floor(columns_needed(like_at_30(e_.main_ensemble(e_.scan_values().back())), deepest_used())) + 1;
    if (!room_for_overloads_) return most;
    for (const double value : e_.scan_values()) most = std::max(most, columns_of_overloads(e_.main_ensemble(value)));
    return most;
  }

  /// Of a number of columns that nobody wrote: the cells of the model and the overloads stand evenly on it.
  int unit_of_columns() const {
    return std::lcm(cell(), e_.response.estimator == EstimatorName::point ? std::max(1, e_.response.overloads) : 1);
  }

  /// The window down to this layer, and the layers that figures show of it.
  void set_window(int last) {
    const auto scaled = [&](int usual) {
      return static_cast<int>(std::lround(static_cast<double>(usual) * last / usual_fit.last_layer));
    };
    if (open("fit.last_layer")) fit_.last_layer = last;
    if (open("fit.first_layer")) {
      fit_.first_layer = scaled(usual_fit.first_layer);
      if (!open("fit.shallow_layer")) fit_.first_layer = std::max(fit_.first_layer, fit_.shallow_layer);
    }
    if (open("fit.layer_step")) fit_.layer_step = handy_step(fit_.last_layer - fit_.first_layer);
    if (open("fit.shallow_layer")) fit_.shallow_layer = std::min(usual_fit.shallow_layer, fit_.first_layer);
    if (!open("figures.response_profiles.layers")) return;
    std::vector<int>& shown = e_.figures.profile_layers;
    shown.clear();
    for (const int usual : usual_figures.profile_layers) shown.push_back(scaled(usual));
    shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
  }

  /// What the estimator fluctuation needs beside its lags: the most of all ensembles.
  int layers_for_fluctuation() const {
    int most = 0;
    for (const double value : e_.scan_values()) {
      most = std::max(most, fluctuation_plan(e_.main_ensemble(value)).layers_needed);
    }
    return most + further_bases_ * e_.response.base_step;
  }

  bool fits(int last) {
    set_window(last);
    if (columns_wanted() > columns_available()) return false;
    return !by_fluctuation() || layers_for_fluctuation() <= e_.lattice.layers;
  }

  /// The deepest window that fits, or else the shallowest one, of which it is told why it cannot be. Overloads that
  /// leave no room for a window do not make it shallow: they are told of.
  void find_window() {
    if (search_window() >= shallow_response || !room_for_overloads_) return;
    room_for_overloads_ = false;
    further_bases_ = usual_bases;
    search_window();
  }

  /// Sets the window and returns its last layer. Rather than a shallow one it has fewer bases.
  int search_window() {
    const int deepest = e_.lattice.layers - margin() - 1;
    const int least = std::max(4, open("fit.first_layer") ? 0 : fit_.first_layer + least_window_depths - 1);
    int low = std::min(least, deepest);
    do {
      int high = deepest;
      if (fits(high)) return high;
      while (low + 1 < high) {
        const int middle = std::midpoint(low, high);
        (fits(middle) ? low : high) = middle;
      }
      further_bases_ -= usual_bases;
    } while (low < shallow_response && further_bases_ >= 0);
    set_window(low);
    return low;
  }

  void derive_lattice() {
    const bool layers_open = open("lattice.layers"), columns_open = open("lattice.columns");
    LatticeSpec usual = usual_lattice();
    if (layers_open) {
      int last = usual.layers - margin() - 1;
      if (!columns_open && std::isfinite(most_beads()))
        last = std::min(last, static_cast<int>(most_beads() / e_.lattice.columns) - margin() - 1);
      if (!open("fit.first_layer")) {
        const double of_usual = static_cast<double>(usual_fit.last_layer) / usual_fit.first_layer;
        last = std::max(last, static_cast<int>(of_usual * fit_.first_layer));
      }
      if (!open("fit.last_layer")) last = fit_.last_layer;
      set_window(last);
      e_.lattice.layers = by_fluctuation() ? layers_for_fluctuation() : deepest_used() + margin() + 1;
    }
    if (open("fit.last_layer")) {
      find_window();
    } else {
      set_window(fit_.last_layer);
    }
    // What lies below a window that the columns have cut short would be drawn for nothing.
    if (layers_open && !by_fluctuation()) e_.lattice.layers = std::max(deepest_used() + 1, 4) + margin();
    if (!columns_open) return;
    const double by_number = most_beads() / e_.lattice.layers;
    const double columns = std::min(std::max<double>(usual.columns, columns_wanted()), by_number);
    constexpr int handy = 20;  // for the Fourier transforms
    const int unit =
        std::isfinite(by_number) ? cell() : std::lcm(unit_of_columns(), columns > usual.columns ? handy : 1);
    e_.lattice.columns = static_cast<int>(std::min(std::ceil(columns / unit) * unit, 2e9));
  }

  void derive_picture() {
    ForceChainSpec& chains = e_.force_chains;
    if (open("scenes.force_chains.mu") && e_.sampling.model.has_contacts()) {
      chains.mu = nearest_with_friction(e_.mu, chains.mu);
    }
    if (e_.sampling.model.is_beads() && e_.sampling.law == Law::granusolve) return;
    if (open("scenes.force_chains.columns")) {
      chains.columns = std::min(chains.columns, e_.lattice.columns);
      chains.columns = std::max(1, chains.columns / cell()) * cell();
    }
    if (!open("scenes.force_chains.layers")) return;
    chains.layers = std::max(1, std::min(chains.layers, e_.lattice.layers - margin()));
    const double most = most_beads() / chains.columns - bottom_margin;
    if (most < chains.layers) chains.layers = std::max(1, static_cast<int>(most));
  }

  Experiment& e_;
  FitSpec& fit_;
  const std::set<std::string>& written_;
  static constexpr int usual_bases = 3;
  int further_bases_ = usual_bases;  ///< of the estimator fluctuation, beyond the first one
  bool room_for_overloads_ = e_.response.estimator == EstimatorName::point && e_.response.overloads > 1;
};

}  // namespace

void derive_values(Experiment& experiment, const std::set<std::string>& written) {
  try {
    (void)experiment.scanned();
  } catch (const InputError&) {
    return;  // of which find_problems tells
  }
  Derivation(experiment, written).go();
}

}  // namespace granuscope
