#include "pipeline/main_figures.h"

#include <memory>

#include "plot/main_finding.h"
#include "plot/point_selection.h"
#include "plot/propagation_against_diffusion.h"
#include "plot/propagation_and_thrust.h"
#include "plot/response_profiles.h"
#include "plot/scaling_with_friction.h"
#include "plot/transport_with_depth.h"

namespace granuscope {

std::vector<FigurePlot> main_figures(const Experiment& experiment, const Analysis& analysis) {
  using Folder = const std::filesystem::path&;
  const FigureSpec& asked = experiment.figures;
  const auto clear = std::make_shared<const Analysis>(without_imprecise_points(analysis));
  std::vector<FigurePlot> figures;
  if (has_main_finding(*clear)) {
    figures.emplace_back([clear](Folder run) { return plot_main_finding(*clear, run); });
  }
  if (asked.response_profiles) {
    const ResponseProfilesSpec spec{experiment.shown_value(asked.profile_mu), asked.profile_layers,
                                    experiment.lattice.layers};
    figures.emplace_back([&analysis, spec](Folder run) { return plot_response_profiles(analysis.results, spec, run); });
  }
  if (asked.transport_with_depth) {
    const TransportWithDepthSpec spec{experiment.shown_value(asked.profile_mu)};
    figures.emplace_back([clear, spec](Folder run) { return plot_transport_with_depth(*clear, spec, run); });
  }
  if (asked.propagation_against_diffusion) {
    figures.emplace_back([clear](Folder run) { return plot_propagation_against_diffusion(*clear, run); });
  }
  if (asked.scaling_with_friction) {
    figures.emplace_back([clear](Folder run) { return plot_scaling_with_friction(*clear, run); });
  }
  if (asked.propagation_and_thrust) {
    figures.emplace_back([clear](Folder run) { return plot_propagation_and_thrust(*clear, run); });
  }
  return figures;
}

}  // namespace granuscope
