#include "pipeline/picture_stage.h"

#include <fmt/format.h>

#include <optional>

#include "ensemble/ensemble_runner.h"
#include "model/audit.h"
#include "plot/figure_words.h"
#include "render/draw.h"
#include "sampling/sampler.h"
#include "storage/pile_file.h"
#include "support/atomic_file.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr const char* figure_id = "force-chains";

/// The pile of the picture as an ensemble of its own, so that the load and the replay command are written once.
EnsembleSpec pile_spec(const Experiment& experiment, double mu) {
  EnsembleSpec spec;
  spec.sampler = experiment.sampler_for(mu);
  spec.lattice = {experiment.force_chains.columns, experiment.force_chains.computed_layers()};
  spec.load = Load::point;
  spec.overload = experiment.response.overload;
  return spec;
}

/// Draws the pile, or says why it could not be completed and how to meet the same failure.
std::optional<std::string> why_not_drawn(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  const auto failure = make_sampler(spec.sampler, pile.lattice)->draw(sample, top_load(spec), pile);
  if (!failure) return std::nullopt;
  return fmt::format(
      "could not be completed: the effort ran out in layer {}. Raise the effort or choose another sample; this command "
      "meets the same failure: {}",
      failure->layer, replay_command(spec, sample));
}

/// All columns of the shown layers.
std::string window_text(const std::array<double, 4>& window) {
  return fmt::format("{},{},{},{}", exact(window[0]), exact(window[1]), exact(window[2]), exact(window[3]));
}

}  // namespace

Pile pile_for_figures(const Experiment& experiment, double mu) {
  const EnsembleSpec spec = pile_spec(experiment, mu);
  Pile pile{Lattice(spec.lattice)};
  if (const auto why = why_not_drawn(spec, experiment.force_chains.sample, pile)) {
    throw InputError("the pile of the figure of one bead's forces " + *why);
  }
  return pile;
}

PictureOutcome draw_force_chains(const Experiment& experiment, const std::filesystem::path& run_folder,
                                 const Provenance& provenance) {
  const ForceChainSpec& chains = experiment.force_chains;
  const EnsembleSpec spec = pile_spec(experiment, chains.mu);
  const std::string replay = replay_command(spec, chains.sample);
  Pile pile{Lattice(spec.lattice)};
  if (const auto why = why_not_drawn(spec, chains.sample, pile)) {
    throw EnvironmentError("the pile of the force-chain picture " + *why);
  }
  make_folder(run_folder / "piles");
  make_folder(run_folder / "figures");
  const std::filesystem::path pile_file = std::filesystem::path("piles") / fmt::format("{}.h5", figure_id);
  write_pile(run_folder / pile_file, pile);

  SceneSpec scene = chains.scene;
  scene.window = {{-0.5 * chains.columns, 0.5 * chains.columns, 0.0, static_cast<double>(chains.layers - 1)}};
  PictureOutcome outcome;
  Figure& figure = outcome.figure;
  figure.id = figure_id;
  figure.screen = figure.print = std::filesystem::path("figures") / fmt::format("{}.png", figure_id);
  figure.redraw = fmt::format(
      "{} && granuscope render pile.h5 --image {}.png --scene {} --width {} --dpi {} --window {} "
      "--colour-map {}",
      replay, figure_id, scene.scene, scene.width_px, exact(scene.dpi), window_text(*scene.window), scene.colour_map);
  const SceneStatistics drawn = draw_pile(pile, scene, run_folder / figure.screen,
                                          {{"Software", provenance_line(provenance)}, {"Source", figure.redraw}});
  set_words(figure, "pictures/force_chains.words",
            {{"columns", std::to_string(chains.columns)},
             {"layers", std::to_string(chains.layers)},
             {"computed_layers", std::to_string(chains.computed_layers())},
             {"mu", caption_number(chains.mu)},
             {"overload", caption_number(experiment.response.overload)},
             {"sample", std::to_string(chains.sample)},
             {"seed", std::to_string(experiment.sampling.seed)},
             {"drawn", std::to_string(drawn.counts.drawn)},
             {"too_faint", std::to_string(drawn.counts.too_faint)},
             {"outside", std::to_string(drawn.counts.outside)}});
  outcome.environment = {{"OpenGL", drawn.renderer}, {"GL backend", drawn.backend + ": " + drawn.backend_reason}};
  const AuditResult residuals = audit(pile);
  outcome.checks.push_back(
      fmt::format("The pile of the force chains was audited in normal and tangential components, which is not the form "
                  "it was drawn "
                  "in: relative to the largest force of a layer, no balance is off by more than {} and no force leaves "
                  "its friction "
                  "cone by more than {}.",
                  significant(residuals.max_balance_residual, 2), significant(residuals.max_cone_violation, 2)));
  outcome.skipped.push_back(fmt::format(
      "The picture draws {} contacts; {} outside its window and {} too faint to change a pixel were left out.",
      drawn.counts.drawn, drawn.counts.outside, drawn.counts.too_faint));
  return outcome;
}

}  // namespace granuscope
