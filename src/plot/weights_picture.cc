#include "plot/weights_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "render/field_scene.h"
#include "render/pile_scene.h"
#include "sampling/sampler.h"
#include "support/atomic_file.h"
#include "support/error.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

Field weights_of(const WeightsPicture& picture) {
  const Lattice lattice(picture.pile.lattice);
  const auto sampler = make_sampler(picture.pile.sampler, lattice);
  const std::vector<double> load = top_load(picture.pile);
  const std::array<std::uint64_t, 1> samples{picture.sample};
  const std::array<std::span<const double>, 1> loads{load};
  std::array<std::optional<SamplingFailure>, 1> failures;
  const PileGroup pile = sampler->draw_groups(samples, loads, failures).front();
  if (failures.front()) {
    throw InputError(fmt::format("the pile of the picture {} could not be completed: the effort ran out in layer {}",
                                 picture.id, failures.front()->layer));
  }
  const RowGeometry rows = rows_of(picture.pile.sampler.model);
  Field field;
  field.key_title = key_title_of("weight");
  for (int layer = 0; layer < lattice.layers() && rows.depth(layer) <= picture.depth; ++layer) {
    FieldRow row{rows.depth(layer), lattice.x(rows.shifted(layer) ? 1 : 0, 0) - 0.5, {}};
    for (int bead = 0; bead < lattice.columns(); ++bead) {
      row.values.push_back(pile.weight(pile.row(layer) + static_cast<std::size_t>(bead) * pile.stride));
    }
    field.rows.push_back(std::move(row));
  }
  return field;
}

}  // namespace

Figure render_weights(const WeightsPicture& picture, const std::filesystem::path& run_folder,
                      SceneStatistics& statistics) {
  SceneSpec scene = picture.scene;
  scene.scene = "field";
  scene.colour_map = "grey";
  const double half = 0.5 * picture.pile.lattice.columns;
  scene.window = {{-half, half, 0, (picture.depth - Lattice::depth(0)) / RowGeometry{}.spacing}};
  Figure figure;
  figure.id = picture.id;
  figure.screen = figure.print = std::filesystem::path("figures") / (picture.id + ".png");
  figure.redraw = picture.redraw;
  set_captions(figure, picture.wording);
  try {
    make_folder(run_folder / "figures");
    statistics = render_scene(build_field_scene(weights_of(picture), scene), scene, run_folder / figure.screen,
                              {{"Software", provenance_line(collect_provenance())}});
  } catch (const EnvironmentError& failure) {
    figure.failure = failure.what();
    figure.screen.clear();
    figure.print.clear();
  }
  return figure;
}

}  // namespace granuscope
