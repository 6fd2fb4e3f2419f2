#include "plot/bead_forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "render/scene.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/files.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

constexpr const char* figure_id = "bead-forces";
constexpr double arrow_length = 0.8;  ///< of the largest of the four forces, bead diameters
constexpr double shown_width = 1.75;  ///< half the width of the picture of the lattice, bead diameters
constexpr double shown_depth = 1.5;   ///< half its height

/// One of the four contacts of a bead, seen from its centre: x to the right, z down.
struct ContactForce {
  double x, z;    ///< of the contact, bead diameters from the bead's centre
  double fx, fz;  ///< the force that the contact pushes onto the bead
  double N, T;    ///< its normal and tangential part; the four T add up to 0 (torque)

  double size() const { return std::hypot(fx, fz); }
  double angle() const { return std::atan2(T, N) * 180 / std::numbers::pi; }  ///< to the contact's direction, degrees
};

/// Force (V, H) that a right contact (towards the lower right) or a left one pushes onto the bead below it.
struct PushedDown {
  double V, H;
  bool right;
};

ContactForce contact_force(const BeadGeometry& to, PushedDown force, bool from_above) {
  // A right contact seen from its lower bead lies to the upper left.
  const double side = force.right == from_above ? -1 : 1;
  const double sign = from_above ? 1 : -1;
  ContactForce contact{};
  contact.x = 0.25 * side * to.twice_sine;
  contact.z = (from_above ? -to.twice_cosine : to.twice_cosine) / 4;
  contact.fx = sign * force.H;
  contact.fz = sign * force.V;
  const double sine = (force.right ? 0.5 : -0.5) * to.twice_sine, cosine = to.twice_cosine / 2;
  contact.N = cosine * force.V + sine * force.H;
  contact.T = cosine * force.H - sine * force.V;
  return contact;
}

/// Upper left, upper right, lower right, lower left.
using FourContacts = std::array<ContactForce, 4>;

FourContacts contacts_of(const Pile& pile, int layer, int bead) {
  const Lattice& lattice = pile.lattice;
  const std::size_t here = lattice.index(layer, bead);
  const std::size_t left = lattice.index(layer - 1, lattice.upper_left(layer, bead));
  const std::size_t right = lattice.index(layer - 1, lattice.upper_right(layer, bead));
  const BeadGeometry& to = lattice.geometry();
  return {contact_force(to, {pile.V_R[left], pile.H_R[left], true}, true),
          contact_force(to, {pile.V_L[right], pile.H_L[right], false}, true),
          contact_force(to, {pile.V_R[here], pile.H_R[here], true}, false),
          contact_force(to, {pile.V_L[here], pile.H_L[here], false}, false)};
}

bool shows_four_forces(const FourContacts& contacts) {
  double sum = 0, least = contacts[0].size();
  for (const ContactForce& contact : contacts) {
    sum += contact.size();
    least = std::min(least, contact.size());
  }
  return least >= 0.5 * sum / 4;
}

int choose_bead(const Pile& pile, int layer) {
  const Lattice& lattice = pile.lattice;
  int chosen = lattice.middle();
  double distance = std::numeric_limits<double>::infinity();
  for (int bead = 0; bead < lattice.columns(); ++bead) {
    const double from_axis = std::abs(lattice.x(layer, bead));
    if (from_axis >= distance || !shows_four_forces(contacts_of(pile, layer, bead))) continue;
    chosen = bead;
    distance = from_axis;
  }
  return chosen;
}

/// Centres of the beads around the chosen one that lie in the picture, itself left out.
CsvTable surrounding_beads(const Lattice& lattice) {
  CsvTable beads({"x: bead diameters", "z: bead diameters"});
  for (int row = -1; row <= 1; ++row) {
    for (int column = -3; column <= 3; ++column) {
      const double x = lattice.pitch() * (column + (row % 2 == 0 ? 0.0 : 0.5)), z = row * lattice.spacing();
      const bool in_sight = std::abs(x) - 0.5 < shown_width && std::abs(z) - 0.5 < shown_depth;
      if (in_sight && (row != 0 || column != 0)) beads.add_row({x, z});
    }
  }
  return beads;
}

/// Of each contact its place, the force there and its name.
Json fields_of(const FourContacts& contacts) {
  constexpr std::array names = {"θ₁", "θ₂", "θ₃", "θ₄"};
  Json all = Json::array();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactForce& one = contacts[i];
    std::string degrees = fmt::format("{:.1f}°", std::abs(one.angle()));
    if (one.angle() < 0 && degrees != "0.0°") degrees.insert(0, "−");
    all.push_back({{"number", i + 1},
                   {"x", one.x},
                   {"z", one.z},
                   {"N", one.N},
                   {"T", one.T},
                   {"theta", names[i]},
                   {"angle", degrees}});
  }
  return all;
}

}  // namespace

Figure plot_bead_forces(const Pile& pile, const BeadForcesSpec& spec, const std::filesystem::path& run_folder) {
  if (spec.layer < 1 || spec.layer >= pile.lattice.layers()) {
    throw InputError(
        "the figure of one bead's forces has nothing to show, because the pile has no layer {} with contacts above and "
        "below; plot it from a deeper pile, or switch the figure off",
        spec.layer);
  }
  const int bead = choose_bead(pile, spec.layer);
  const FourContacts contacts = contacts_of(pile, spec.layer, bead);
  CsvTable table({"contact: dimensionless", "x: bead diameters", "z: bead diameters", "fx: loads of one top bead",
                  "fz: loads of one top bead", "normal: loads of one top bead", "tangential: loads of one top bead",
                  "theta_degrees: degrees"});
  double largest = 0, strongest_N = 0, strongest_T = 0, number = 0;
  for (const ContactForce& contact : contacts) {
    table.add_row({++number, contact.x, contact.z, contact.fx, contact.fz, contact.N, contact.T, contact.angle()});
    largest = std::max(largest, contact.size());
    strongest_N = std::max(strongest_N, contact.N);
    strongest_T = std::max(strongest_T, std::abs(contact.T));
  }
  Range normal, tangential;
  normal.add(0);
  normal.add(1.18 * strongest_N);
  const double half_height = 1.15 * std::max({pile.mu * normal.high, strongest_T, 0.05 * strongest_N});
  tangential.add(-half_height);
  tangential.add(half_height);

  Plot plot;
  plot.id = figure_id;
  plot.height = 3.05;
  plot.add_data("contacts", table);
  plot.add_data("beads", surrounding_beads(pile.lattice));
  plot.other_curves = 6;
  plot.own = {{"mu", pile.mu},
              {"layer", spec.layer},
              {"shown_width", shown_width},
              {"shown_depth", shown_depth},
              {"scale", largest > 0 ? arrow_length / largest : 1},
              {"contacts", fields_of(contacts)},
              {"normal", axis_json(linear_axis("normal force N", normal, 5))},
              {"tangential", axis_json(linear_axis("tangential force T", tangential, 6))}};
  plot.key = {.inches = 0.52, .lines = 2, .sample = 2.2, .entries = {}};
  plot.add_key("forces on the bead", {.colour = "blue", .width = 2.2});
  plot.add_key("contact directions, 30° from the vertical", {.width = 0.9, .dash = 2});
  plot.add_key("friction cones |T| ≤ μN", {.with = "filledcurves", .colour = "sky_blue"});
  double x = pile.lattice.x(spec.layer, bead);
  return plot_figure(plot,
                     {"plot/bead_forces.captions",
                      {{"mu", caption_number(pile.mu)},
                       {"phi", fmt::format("{:.1f}", std::atan(pile.mu) * 180 / std::numbers::pi)},
                       {"layer", std::to_string(spec.layer)},
                       {"x", caption_number(x)},
                       {"columns", std::to_string(pile.lattice.columns())},
                       {"layers", std::to_string(pile.lattice.layers())},
                       {"sample", std::to_string(pile.sample)},
                       {"seed", std::to_string(pile.seed)},
                       {"rule", shows_four_forces(contacts) ? "yes" : ""}},
                      terms_of(friction_parameter(), pile.lattice.geometry().angle)},
                     run_folder);
}

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
    throw InputError("the pile of the picture {} could not be completed: the effort ran out in layer {}", picture.id,
                     failures.front()->layer);
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
