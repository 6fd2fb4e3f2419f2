#include "pipeline/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "ensemble/ensemble_runner.h"
#include "model/audit.h"
#include "plot/bead_forces.h"
#include "plot/figure_captions.h"
#include "plot/plot_texts.h"
#include "plot/response_field.h"
#include "render/gl_context.h"
#include "render/render_pile.h"
#include "render/scene.h"
#include "report/touched_pile.h"
#include "sampling/sampler.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr const char* figure_id = "force-chains";
/// Of what is no pile of beads, which the verb render would take.
constexpr const char* render_again =
    "cp experiment.toml again.toml && granuscope run again.toml --out . --only analyse --only render";
/// Of the pictures with a name of their own.
constexpr const char* free_captions = "pictures/free.captions";
constexpr std::string_view free_prefix = "picture-";
/// Of the text's 8 pt some 11 pixels are left on a phone, which has two or three of its own for each.
constexpr double phone_width_mm = 84, phone_dpi = 200;

/// Draws the pile, or says why it could not be completed and how to meet the same failure.
std::optional<std::string> why_not_drawn(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile) {
  const auto failure = make_sampler(spec.sampler, pile.lattice)->draw(sample, top_load(spec), pile);
  if (!failure) return std::nullopt;
  return fmt::format(
      "could not be completed: the effort ran out in layer {}. Raise the effort or choose another sample; this command "
      "meets the same failure: {}",
      failure->layer, replay_command(spec, sample));
}

/// The picture is not there, and why.
void set_failure(Figure& figure, const EnvironmentError& failure) {
  figure.failure = failure.what();
  figure.screen.clear();
  figure.narrow.clear();
  figure.print.clear();
}

std::vector<std::pair<std::string, std::string>> environment_of(const SceneStatistics& statistics) {
  return {{"OpenGL", statistics.renderer}, {"GL backend", statistics.backend + ": " + statistics.backend_reason}};
}

/// "x0,x1,first layer,last layer", as the flag --window has it.
std::string window_text(const std::array<double, 4>& window) {
  return fmt::format("{},{},{},{}", exact(window[0]), exact(window[1]), exact(window[2]), exact(window[3]));
}

}  // namespace

EnsembleSpec pile_spec(const Experiment& experiment, double mu) {
  EnsembleSpec spec;
  spec.sampler = experiment.sampling.model.is_beads()
                     ? experiment.sampler_for(mu)
                     : experiment.sampler_at(experiment.shown_value(experiment.figures.profile_mu));
  spec.lattice = {experiment.force_chains.columns, experiment.force_chains.computed_layers(), experiment.lattice.angle};
  spec.load = Load::point;
  spec.response.overload = experiment.response.overload;
  return spec;
}

bool needs_pair(const Experiment& experiment) {
  return (experiment.force_chains.response && experiment.sampling.model.is_beads()) ||
         std::ranges::any_of(experiment.pictures, [](const auto& one) { return needs_two_piles(one.second.scene); });
}

void require_backend(const ForceChainSpec& chains) {
  const std::string& backend = chains.scene.backend;
  if (chains.show && backend != "none" && backend != "auto") make_gl_context(backend);
}

Pile pile_for_figures(const Experiment& experiment, double mu) {
  const EnsembleSpec spec = pile_spec(experiment, mu);
  Pile pile{Lattice(spec.lattice)};
  if (const auto why = why_not_drawn(spec, experiment.force_chains.sample, pile)) {
    throw InputError("the pile of the figure of one bead's forces " + *why);
  }
  return pile;
}

namespace {

/// Renders pictures of the experiment's pile, one scene after the other, each from the files the report keeps.
class PilePictures {
 public:
  PilePictures(const Experiment& experiment, const std::filesystem::path& run_folder, const Provenance& provenance)
      : experiment_(experiment),
        chains_(experiment.force_chains),
        folder_(run_folder),
        software_(provenance_line(provenance)),
        spec_(pile_spec(experiment, experiment.force_chains.mu)),
        pile_(Lattice(spec_.lattice)) {
    if (const auto why = why_not_drawn(spec_, chains_.sample, pile_)) {
      throw InputError("the pile of the force-chain picture " + *why);
    }
    keep(figure_id, pile_);
  }

  /// Keeps a pile beside the pictures. That it cannot be kept costs neither them nor the report.
  void keep(const std::string& name, const Pile& pile) {
    try {
      make_folder(folder_ / "piles");
      write_pile(folder_ / "piles" / (name + ".h5"), pile);
    } catch (const EnvironmentError& failure) {
      not_kept_.emplace_back(fmt::format("the pile {}", name), failure.what());
    }
  }
  const std::vector<std::pair<std::string, std::string>>& not_kept() const { return not_kept_; }

  const Pile& pile() const { return pile_; }

  /// The pile under the uniform load, and beside it the same under the overload, every bead keeping its random number
  /// unless a repair changes its split. Nothing if one of them could not be completed.
  std::optional<std::pair<Pile, Pile>> pair() const {
    const auto sampler = make_sampler(spec_.sampler, pile_.lattice);
    EnsembleSpec uniform = spec_;
    uniform.load = Load::uniform;
    Pile first(pile_.lattice), second(pile_.lattice);
    if (sampler->draw(chains_.sample, top_load(uniform), first)) return std::nullopt;
    if (sampler->draw_again(chains_.sample, top_load(spec_), first, second)) return std::nullopt;
    return std::pair{std::move(first), std::move(second)};
  }

  PictureOutcome render(const std::string& id, const char* captions, SceneSpec scene, const Pile& pile,
                        const Pile* minus, const std::string& redraw) const {
    if (!scene.window) {
      const double half = pile_.lattice.half_width();
      scene.window = {{-half, half, 0.0, static_cast<double>(chains_.layers - 1)}};
    }
    PictureOutcome outcome;
    Figure& figure = outcome.figure;
    figure.id = id;
    figure.screen = figure.print = std::filesystem::path("figures") / fmt::format("{}.png", id);
    figure.redraw = fmt::format(
        "{} --image {}.png --scene {} --width {} --dpi {} --window={}{}{}", redraw, id, scene.scene, scene.width_px,
        exact(scene.dpi), window_text(*scene.window),
        scene.range ? fmt::format(" --range={},{}", exact((*scene.range)[0]), exact((*scene.range)[1])) : "",
        scene.colour_map.empty() ? "" : " --colour-map " + scene.colour_map);
    SceneStatistics statistics;
    try {
      make_folder(folder_ / "figures");
      statistics = render_pile(pile, minus, scene, folder_ / figure.screen,
                               {{"Software", software_}, {"Source", figure.redraw}});
      if (scene.width_px > 1.4 * phone_width_mm / 25.4 * scene.dpi) {  // its text would be too small to be read there
        scene.dpi = std::min(scene.dpi, phone_dpi);
        scene.width_px = static_cast<int>(phone_width_mm / 25.4 * scene.dpi);
        figure.narrow = std::filesystem::path("figures") / fmt::format("{}-narrow.png", id);
        render_pile(pile, minus, scene, folder_ / figure.narrow, {{"Software", software_}});
      }
    } catch (const EnvironmentError& failure) {  // its words, which stand among the numbers, are the same
      set_failure(figure, failure);
      statistics.counts = count_elements(pile, minus, scene);
    }
    TemplateVariables variables{
        {"columns", std::to_string(chains_.columns)}, {"layers", std::to_string(chains_.layers)},
        {"mu", caption_number(chains_.mu)},           {"overload", caption_number(experiment_.response.overload)},
        {"sample", std::to_string(chains_.sample)},   {"seed", std::to_string(experiment_.sampling.seed)}};
    if (std::string_view(captions) == free_captions) {
      variables["name"] = id.substr(free_prefix.size());
      variables["shown"] = key_title_of(scene.scene);
      variables["x0"] = caption_number((*scene.window)[0]);
      variables["x1"] = caption_number((*scene.window)[1]);
      variables["first"] = caption_number((*scene.window)[2]);
      variables["last"] = caption_number((*scene.window)[3]);
    }
    if (id == figure_id) {  // what was skipped is told once
      variables["computed_layers"] = std::to_string(chains_.computed_layers());
      variables["shown"] = std::to_string(statistics.counts.drawn + statistics.counts.aggregated);
      variables["too_faint"] = std::to_string(statistics.counts.too_faint);
      variables["outside"] = std::to_string(statistics.counts.outside);
    }
    set_captions(figure, {captions, variables, terms_of(friction_parameter(), spec_.lattice.angle)});
    if (!figure.is_there()) return outcome;
    outcome.environment = environment_of(statistics);
    outcome.skipped.push_back(fmt::format(
        "The picture {} shows {} elements; {} outside its window and {} too faint to change a pixel were left out.", id,
        statistics.counts.drawn + statistics.counts.aggregated, statistics.counts.outside,
        statistics.counts.too_faint));
    return outcome;
  }

  std::string replay() const { return replay_command(spec_, chains_.sample); }

 private:
  const Experiment& experiment_;
  const ForceChainSpec& chains_;
  std::filesystem::path folder_;
  std::string software_;
  EnsembleSpec spec_;
  Pile pile_;
  std::vector<std::pair<std::string, std::string>> not_kept_;
};

/// The picture of a model: there are no contacts of beads to be shown.
PictureOutcome render_weights_of_model(const Experiment& experiment, const std::filesystem::path& run_folder) {
  const ForceChainSpec& chains = experiment.force_chains;
  const EnsembleSpec pile = pile_spec(experiment, chains.mu);
  const TemplateVariables variables = {
      {"model", name_of(pile.sampler.model.name)}, {"at", experiment.scanned().at(pile.sampler)},
      {"columns", std::to_string(chains.columns)}, {"overload", caption_number(experiment.response.overload)},
      {"sample", std::to_string(chains.sample)},   {"seed", std::to_string(experiment.sampling.seed)}};
  SceneStatistics statistics;
  PictureOutcome outcome;
  outcome.figure = render_weights({.id = "model-weights",
                                   .pile = pile,
                                   .sample = chains.sample,
                                   .depth = Lattice::depth(chains.layers - 1),
                                   .scene = chains.scene_beside(),
                                   .wording = {"pictures/model_weights.captions", variables},
                                   .redraw = render_again},
                                  run_folder, statistics);
  if (outcome.figure.is_there()) outcome.environment = environment_of(statistics);
  return outcome;
}

}  // namespace

std::vector<PictureOutcome> render_pile_pictures(const Experiment& experiment, const std::filesystem::path& run_folder,
                                                 const Provenance& provenance) {
  if (!experiment.sampling.model.has_contacts()) return {render_weights_of_model(experiment, run_folder)};
  const ForceChainSpec& chains = experiment.force_chains;
  PilePictures pictures(experiment, run_folder, provenance);
  const std::string redraw = pictures.replay() + " && granuscope render pile.h5";
  std::vector<PictureOutcome> outcomes;
  outcomes.push_back(
      pictures.render(figure_id, "pictures/force_chains.captions", chains.scene, pictures.pile(), nullptr, redraw));
  const AuditResult residuals = audit(pictures.pile());
  outcomes.front().checks.push_back(fmt::format(
      "The pile of the force chains was audited in normal and tangential components, which is not the form "
      "it was drawn in: relative to the largest force of a layer, no balance is off by more than {} and no "
      "force leaves its friction cone{}.",
      significant(residuals.max_balance_residual, 2),
      residuals.max_cone_violation > 0 ? " by more than " + significant(residuals.max_cone_violation, 2) : ""));
  const auto scene_beside = [&](const char* name) {
    SceneSpec scene = chains.scene_beside();
    scene.scene = name;
    if (scene.scene != "weight") scene.colour_map.clear();
    return scene;
  };
  if (chains.weight) {
    outcomes.push_back(pictures.render("bead-weights", "pictures/weight.captions", scene_beside("weight"),
                                       pictures.pile(), nullptr, redraw));
  }
  if (chains.friction) {
    outcomes.push_back(pictures.render("mobilised-friction", "pictures/friction.captions", scene_beside("friction"),
                                       pictures.pile(), nullptr, redraw));
  }
  std::optional<std::pair<Pile, Pile>> pair;
  if (needs_pair(experiment)) pair = pictures.pair();
  if (pair) {
    pictures.keep("uniform", pair->first);
    pictures.keep("overloaded", pair->second);
  }
  outcomes.front().figure.touched =
      touched_pile(pictures.pile(), pair ? &pair->second : nullptr, pair ? &pair->first : nullptr, chains.layers);
  outcomes.front().not_kept = pictures.not_kept();
  const char* const redraw_pair = "granuscope render piles/overloaded.h5 --minus piles/uniform.h5";
  if (chains.response && experiment.sampling.model.is_beads()) {
    if (pair) {
      outcomes.push_back(pictures.render("pile-response", "pictures/response.captions", scene_beside("response"),
                                         pair->second, &pair->first, redraw_pair));
    } else {
      outcomes.back().skipped.emplace_back(
          "The response of the picture's pile is left out: it could not be solved again under the other load.");
    }
  }
  for (const auto& [name, picture] : experiment.pictures) {
    const SceneSpec scene = picture.scene_like(chains, experiment.lattice.angle);
    const std::string id = std::string(free_prefix) + name;
    if (!needs_two_piles(scene.scene)) {
      outcomes.push_back(pictures.render(id, free_captions, scene, pictures.pile(), nullptr, redraw));
    } else if (pair) {
      outcomes.push_back(pictures.render(id, free_captions, scene, pair->second, &pair->first, redraw_pair));
    } else {
      outcomes.back().skipped.push_back(
          fmt::format("The picture {} is left out: its pile could not be solved again under the other load.", id));
    }
  }
  return outcomes;
}

PictureOutcome render_response_field(const Experiment& experiment, Field field, const Transport& transport,
                                     const std::filesystem::path& run_folder, const Provenance& provenance) {
  SceneSpec spec = experiment.force_chains.scene_beside();
  spec.scene = "field";
  spec.colour_map = "grey";
  const double last = field.rows.back().z,
               half = 0.5 * (field.rows.back().left_of(field.rows.back().values.size()) - field.rows.back().x0);
  // A little more than the light cone of the frictionless pile; layers as the scene counts them.
  const double reach = std::min(half - 1, std::ceil(transport.c0() * last) + 10);
  const auto layer_at = [](double z) { return std::round((z - 0.5) / (sqrt3 / 2)); };
  spec.window = {{-reach, reach, 0, layer_at(last)}};
  PictureOutcome outcome;
  Figure& figure = outcome.figure;
  figure.id = "response-field";
  figure.screen = figure.print = std::filesystem::path("figures") / "response-field.png";
  figure.redraw = render_again;
  SceneStatistics statistics;
  try {
    make_folder(run_folder / "figures");
    figure.data = {std::filesystem::path("figures") / "response-field.csv"};
    write_file(run_folder / figure.data.front(), response_field_csv(field, transport));
    put_fit_on_the_right(field, transport);
    const Scene scene = build_field_scene(field, spec);
    statistics = render_scene(scene, spec, run_folder / figure.screen, {{"Software", provenance_line(provenance)}});
  } catch (const EnvironmentError& failure) {
    set_failure(figure, failure);
  }
  set_captions(figure, {"pictures/response_field.captions",
                        {{"mu", caption_number(transport.scanned())},
                         {"samples", std::to_string(transport.samples)},
                         {"estimator", name_of(transport.spec.response.estimator)},
                         {"fitted", transport.c.known() && transport.D.known() ? "yes" : ""}},
                        terms_of(*transport.scan, transport.spec.lattice.angle)});
  if (figure.is_there()) outcome.environment = environment_of(statistics);
  return outcome;
}

}  // namespace granuscope
