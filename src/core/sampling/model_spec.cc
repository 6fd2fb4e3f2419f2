#include "sampling/model_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr Names<ModelName, all_models.size()> model_names{{{ModelName::frictional_beads, "frictional-beads"},
                                                           {ModelName::q_model, "q-model"},
                                                           {ModelName::three_leg, "three-leg"},
                                                           {ModelName::stochastic_osl, "stochastic-osl"},
                                                           {ModelName::diluted_beads, "diluted-beads"}}};
constexpr Names<SplitLaw, 3> split_names{
    {{SplitLaw::uniform, "uniform"}, {SplitLaw::critical, "critical"}, {SplitLaw::beta, "beta"}}};
constexpr Names<NoiseLaw, 2> noise_names{{{NoiseLaw::uniform, "uniform"}, {NoiseLaw::gaussian, "gaussian"}}};
constexpr Names<MiddleLaw, 3> middle_names{
    {{MiddleLaw::free, "free"}, {MiddleLaw::positive, "positive"}, {MiddleLaw::clipped, "clipped"}}};

bool has_free_noise(const ModelSpec& model) {
  return model.name == ModelName::three_leg && model.three_leg.law != MiddleLaw::positive;
}

constexpr std::array<const char*, 2> three_leg_extras = {"middle", "traction"};

Problem find_cell_problem(const std::string& table, int cell_columns, const LatticeSpec& lattice) {
  if (lattice.columns % cell_columns != 0 || cell_columns > lattice.columns / 4) {
    return problem(table + ".cell_columns",
                   "cells of {} columns do not fill a ring of {}, of which at least four must fit, so that the noise "
                   "would not be the same everywhere; give a divisor of it",
                   cell_columns, lattice.columns);
  }
  return {};
}

Problem find_problem(const ThreeLegSpec& spec, const LatticeSpec& lattice) {
  if (!(spec.noise >= 0 && spec.noise <= spec.middle && spec.middle + spec.noise <= 1)) {
    return problem("three_leg.noise", "the share of the middle leg would leave [0, 1] with {} +- {}; give at most {}",
                   spec.middle, spec.noise, std::min(spec.middle, 1 - spec.middle));
  }
  const bool cells = spec.cell_columns != 1 || spec.cell_rows != 1;
  if (cells && spec.law != MiddleLaw::free) {
    return problem("three_leg.cell_columns",
                   "under the law {} each bead has bounds of its own, so that cells cannot have one share; leave the "
                   "cells at 1, or choose free",
                   name_of(spec.law));
  }
  return find_cell_problem("three_leg", spec.cell_columns, lattice);
}

Problem find_problem(const StochasticOslSpec& spec, const LatticeSpec& lattice) {
  // Cut at four standard deviations, a Gaussian loses a thousandth of its variance.
  constexpr double most_gaussian = 0.25;
  if (spec.noise == NoiseLaw::gaussian && !(spec.disorder >= 0 && spec.disorder <= most_gaussian)) {
    return problem("stochastic_osl.disorder",
                   "with a standard deviation of {} a Gaussian v would often be below -1, where sigma_xx changes sign "
                   "and no wave propagates; give 0 to {}, or choose uniform noise",
                   spec.disorder, most_gaussian);
  }
  return find_cell_problem("stochastic_osl", spec.cell_columns, lattice);
}

Problem find_diluted_problem(const LatticeSpec& lattice) {
  if (static_cast<double>(lattice.columns) * lattice.layers > most_diluted_beads) {
    return problem("columns",
                   "{} x {} beads with opened contacts are solved as a whole, in a time that grows as the third power "
                   "of their number; give at most {} beads",
                   lattice.columns, lattice.layers, most_diluted_beads);
  }
  return {};
}

}  // namespace

RowGeometry rows_of(const ModelSpec& model, double angle) {
  if (model.name == ModelName::three_leg) return {.spacing = sqrt3, .staggered = false};
  if (model.name == ModelName::stochastic_osl) return {.spacing = sqrt3 / 2, .staggered = false};
  const BeadGeometry geometry(angle);
  return {.spacing = geometry.twice_cosine / 2, .pitch = geometry.twice_sine};
}

int bottom_margin_of(const ModelSpec& model) {
  constexpr int of_diluted = 5;
  if (model.is_beads()) return bottom_margin;
  return model.name == ModelName::diluted_beads ? of_diluted : 0;
}

// Exact of the q-model and of free legs but for their noise; the others as measured.
double rough_spreading(const ModelSpec& model) {
  switch (model.name) {
    case ModelName::q_model:
      return 1 / (2 * sqrt3);
    case ModelName::three_leg:
      return model.three_leg.law == MiddleLaw::positive ? 0.22 * model.three_leg.share
                                                        : model.three_leg.middle / (2 * sqrt3);
    case ModelName::stochastic_osl: {
      const StochasticOslSpec& osl = model.stochastic_osl;
      return 0.01 * osl.disorder * osl.disorder * osl.cell_columns * osl.cell_rows;
    }
    case ModelName::frictional_beads:
    case ModelName::diluted_beads:
      break;
  }
  throw std::logic_error("beads are no model that hands forces down row by row");
}

double speed_without_disorder(const ModelSpec& model) { return model.name == ModelName::q_model ? 0 : tan30; }

std::span<const char* const> extra_names(const ModelSpec& model) {
  if (model.name == ModelName::three_leg) return three_leg_extras;
  return {};
}

namespace {

/// "model.three_leg", which holds the keys of the model.
std::string table_of(const ModelSpec& model) {
  std::string table = "model." + name_of(model.name);
  std::replace(table.begin(), table.end(), '-', '_');
  return table;
}

}  // namespace

Problem find_problem(const ModelSpec& model, const LatticeSpec& lattice) {
  ModelSpec copy = model;  // keys could set what they check
  for (const Key& key : keys_of(copy)) {
    if (key.table != table_of(model)) continue;
    if (auto found = find_range_problem(key)) return problem(key.path().substr(6), "{}", found->message);
  }
  if (model.name == ModelName::three_leg) return find_problem(model.three_leg, lattice);
  if (model.name == ModelName::stochastic_osl) return find_problem(model.stochastic_osl, lattice);
  if (model.name == ModelName::diluted_beads) return find_diluted_problem(lattice);
  return {};
}

std::string configuration_text(const ModelSpec& model) {
  if (model.is_beads()) return {};
  std::string text = fmt::format("model={}\n", name_of(model.name));
  if (model.name == ModelName::q_model) {
    text += fmt::format("split={}\n", name_of(model.q_model.split));
    if (model.q_model.disorder != 1) text += fmt::format("disorder={}\n", exact(model.q_model.disorder));
  }
  if (model.name == ModelName::three_leg) {
    const ThreeLegSpec& legs = model.three_leg;
    // Files of before hold shares of beads that are pulled, which mean nothing.
    text += fmt::format("middle_law={}\nmiddle_sums=2\n", name_of(legs.law));
    if (legs.law == MiddleLaw::positive) {
      text += fmt::format("share={}\n", exact(legs.share));
    } else {
      text += fmt::format("middle={}\nnoise={}\ncells={}x{}\n", exact(legs.middle), exact(legs.noise),
                          legs.cell_columns, legs.cell_rows);
    }
  }
  if (model.name == ModelName::stochastic_osl) {
    const StochasticOslSpec& osl = model.stochastic_osl;
    // Files of before hold the thrust at the top of each row.
    text += fmt::format("disorder={}\ncells={}x{}\ngrid={}\nthrust_sums=2\n", exact(osl.disorder), osl.cell_columns,
                        osl.cell_rows, osl.grid);
    if (osl.noise != NoiseLaw::uniform) text += fmt::format("noise={}\n", name_of(osl.noise));
  }
  if (model.name == ModelName::diluted_beads) {
    text += fmt::format("opened_share={}\nleast_slack={}\n", exact(model.diluted_beads.share),
                        exact(model.diluted_beads.least_slack));
  }
  return text;
}

bool read_configuration(ModelSpec& model, const std::string& name, const std::string& value) {
  if (name == "model") {
    model.name = model_named(value);
    return true;
  }
  const std::string table = table_of(model);
  bool known = false;
  for (const Key& key : keys_of(model)) {
    const std::size_t by = value.find('x');
    const bool columns = key.name == "cell_columns", cells = name == "cells" && (columns || key.name == "cell_rows");
    if (name == "law" || key.table != table || !(cells || key.name == (name == "middle_law" ? "law" : name))) continue;
    key.read(!cells || by == std::string::npos ? value : columns ? value.substr(0, by) : value.substr(by + 1));
    known = true;
  }
  return known;
}

std::span<const ModelParameter> model_parameters() {
  static constexpr std::array parameters = {
      ModelParameter{"disorder", "Δ", "disorder of the shares",
                     [](const ModelSpec& model) { return model.name == ModelName::q_model; },
                     [](ModelSpec& model) -> double& { return model.q_model.disorder; }},
      ModelParameter{"middle", "p", "mean share of the middle leg", has_free_noise,
                     [](ModelSpec& model) -> double& { return model.three_leg.middle; }},
      ModelParameter{"noise", "δ", "noise of the share", has_free_noise,
                     [](ModelSpec& model) -> double& { return model.three_leg.noise; }},
      ModelParameter{
          "share", "s", "share of p_max",
          [](const ModelSpec& model) { return model.name == ModelName::three_leg && !has_free_noise(model); },
          [](ModelSpec& model) -> double& { return model.three_leg.share; }},
      ModelParameter{"disorder", "Δ", "standard deviation of the noise",
                     [](const ModelSpec& model) { return model.name == ModelName::stochastic_osl; },
                     [](ModelSpec& model) -> double& { return model.stochastic_osl.disorder; }},
      ModelParameter{"opened_share", "q", "share of opened contacts",
                     [](const ModelSpec& model) { return model.name == ModelName::diluted_beads; },
                     [](ModelSpec& model) -> double& { return model.diluted_beads.share; }},
  };
  return parameters;
}

std::vector<Key> keys_of(ModelSpec& model) {
  const std::string three_leg = "model.three_leg", osl = "model.stochastic_osl", diluted = "model.diluted_beads";
  return {
      make_name_key("model", "name",
                    "what a pile is a model of: frictional-beads (under a law of [sampling]), q-model, three-leg, "
                    "stochastic-osl or diluted-beads (small piles)",
                    model.name, model_named),
      make_name_key("model.q_model", "split",
                    "share q of a bead's weight that its lower left neighbour gets: uniform on [0, 1], critical (0 or "
                    "1), or beta, of density 6 q (1 - q)",
                    model.q_model.split, split_names, "law of the q-model"),
      make_key("model.q_model", "disorder", "", "by how much of that q deviates from 1/2", model.q_model.disorder,
               KeyRange{.why = "a share would leave [0, 1]"}.within(0, 1)),
      make_name_key(
          three_leg, "law",
          "share p of the middle leg: free (middle +- noise), positive (up to a share of the largest with which "
          "no leg pulls) or clipped (middle +- noise, cut to that)",
          model.three_leg.law, middle_names, "law of the three-leg model"),
      make_key(three_leg, "middle", "", "free, clipped: mean of p", model.three_leg.middle,
               KeyRange{.why = "something must be left for the outer legs"}.within(0, 1).below(1)),
      make_key(three_leg, "noise", "", "free, clipped: p is uniform on middle +- noise", model.three_leg.noise),
      make_key(three_leg, "share", "", "positive: of the largest p, up to which p is uniform", model.three_leg.share,
               KeyRange{.why = "it is none, or more than the legs can bear"}.within(0, 1).above(0)),
      make_key(three_leg, "cell_columns", "columns", "free: width of the cells in which noise is the same",
               model.three_leg.cell_columns, KeyRange{.least = 1}),
      make_key(three_leg, "cell_rows", "rows", "free: their height", model.three_leg.cell_rows,
               KeyRange{}.within(1, 1000)),
      make_name_key(osl, "noise", "v in sigma_xx = (1 + v) sigma_zz / 3: uniform or gaussian (cut at |v| = 1)",
                    model.stochastic_osl.noise, noise_names, "noise of stochastic OSL"),
      make_key(osl, "disorder", "", "standard deviation of v", model.stochastic_osl.disorder,
               // v = -1 would stop the waves; with rows sqrt(3)/2 apart the explicit scheme is stable up to v = 3.
               KeyRange{.why = "v would reach -1, where sigma_xx changes sign and no wave propagates"}
                   .within(0, tan30)
                   .below(tan30)),
      make_key(osl, "cell_columns", "bead diameters", "width of the cells in which noise is the same",
               model.stochastic_osl.cell_columns, KeyRange{.least = 1}),
      make_key(osl, "cell_rows", "rows", "their height", model.stochastic_osl.cell_rows, KeyRange{}.within(1, 1000)),
      make_key(osl, "grid", "nodes per bead diameter", "fineness of the explicit scheme", model.stochastic_osl.grid,
               KeyRange{.why = "it is none, or more than a test of convergence needs"}.within(1, 16)),
      make_key(
          diluted, "opened_share", "",
          "of the contacts below the top layer that are opened, one after the other, each only if the pile stays "
          "solvable",
          model.diluted_beads.share,
          KeyRange{.why = "there would be at most as many unknowns as balances, 4 (1 - share) against 3 for each bead"}
              .within(0, 0.25)
              .below(0.25)),
      make_key(
          diluted, "least_slack", "loads of one top bead",
          "smallest N - |T|/mu that all closed contacts must be able to have at once", model.diluted_beads.least_slack,
          // sqrt 3 N is at most the load where it is the same everywhere.
          KeyRange{.why = "not even an undiluted pile has so much in all contacts at once"}.above(0).below(tan30))};
}

std::string law_of(const ModelSpec& model) {
  std::string name = name_of(model.name);
  if (model.name == ModelName::q_model) return name + ", " + name_of(model.q_model.split);
  if (model.name == ModelName::three_leg) return name + ", " + name_of(model.three_leg.law);
  return name;
}

std::string name_of(ModelName name) { return name_in(model_names, name); }
std::string name_of(NoiseLaw law) { return name_in(noise_names, law); }
std::string name_of(SplitLaw law) { return name_in(split_names, law); }
std::string name_of(MiddleLaw law) { return name_in(middle_names, law); }
ModelName model_named(const std::string& name) { return named_in(model_names, name, "model"); }

}  // namespace granuscope
