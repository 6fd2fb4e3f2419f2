#include <cmath>
#include <future>
#include <limits>
#include <optional>

#include "cli/flag_checks.h"
#include "cli/page_options.h"
#include "packing/packing_file.h"
#include "packing/packing_scene.h"
#include "packing/packing_statistics.h"
#include "render/render_pile.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

struct ContactsOptions {
  std::string contacts, particles, walls, histogram, of = "N", on_particles, range, window;
  std::vector<std::string> columns, particle_columns, wall_columns;
  std::optional<double> step, period_x, period_y;
  double mu = std::numeric_limits<double>::quiet_NaN();
  bool json = false, transparent = false, has_mu = false;
  OutputFile image;
  PageOptions page;
  SceneSpec scene;
  FilmOptions film;
};

/// Counts as they are, all else to five digits.
std::string in_words(double value) {
  return value == std::floor(value) && std::abs(value) < 1e15 ? fmt::format("{:.0f}", value) : significant(value, 5);
}

std::string numbers_text(const std::vector<PackingNumber>& numbers, bool json) {
  std::string text;
  for (const PackingNumber& one : numbers) {
    const bool known = std::isfinite(one.value);
    if (json) {
      text += fmt::format("{}\n  \"{}\": {}", text.empty() ? "{" : ",", one.name, known ? exact(one.value) : "null");
    } else if (known) {
      text += fmt::format("{}\t{}\t{}\n", one.name, in_words(one.value), one.about);
    }
  }
  return json ? text + "\n}\n" : aligned(text);
}

/// What --of names, with the unit of a value.
struct NamedDistribution {
  std::string_view name;
  Distributed of;
  std::string_view unit;
};
constexpr std::array<NamedDistribution, 3> distributions{{{"N", Distributed::normal_force, "<N>"},
                                                          {"friction", Distributed::friction, "mu N"},
                                                          {"direction", Distributed::direction, "degrees"}}};

std::string histogram_of(const Packing& packing, const ContactsOptions& options) {
  const auto& [name, of, own_unit] = *std::ranges::find(distributions, options.of, &NamedDistribution::name);
  const std::string_view unit = of == Distributed::friction && !options.has_mu ? "N" : own_unit;
  CsvTable table({fmt::format("from: {}", unit), fmt::format("to: {}", unit), fmt::format("density: 1/({})", unit),
                  fmt::format("standard_error: 1/({})", unit)});
  for (const ForceBin& bin : distribution(packing, of, options.mu)) {
    table.add_row({bin.from, bin.to, bin.density, bin.standard_error});
  }
  return table.text();
}

/// Who is off balance.
std::string particles_table(const Packing& packing) {
  CsvTable table({"id: dimensionless", "x: of the file", "y: of the file", "contacts: dimensionless",
                  "force_x: of the file", "force_y: of the file", "torque: of the file", "largest_force: of the file"});
  const std::vector<OfParticle> sums = forces_on_particles(packing);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const Particle& one = packing.particles[k];
    table.add_row({static_cast<double>(one.id), one.x, one.y, static_cast<double>(sums[k].contacts), sums[k].x,
                   sums[k].y, sums[k].torque, sums[k].largest});
  }
  return table.text();
}

ImageMetadata metadata_of(const ContactsOptions& options) {
  const auto name = std::filesystem::path(options.contacts).filename().string();
  return {{"Title", "contacts of " + single_line(name)}, {"Software", provenance_line(collect_provenance())}};
}

void draw(const Packing& packing, const ContactsOptions& options, VerbContext& context) {
  ImageMetadata metadata = metadata_of(options);
  metadata.emplace_back("Description", how_many(packing.contacts.size(), "contact"));
  const Scene scene = build_packing_scene(packing, options.mu, options.scene);
  if (options.scene.window && !packing.contacts.empty() && scene.counts.drawn + scene.counts.too_faint == 0) {
    SceneSpec whole = options.scene;
    whole.window.reset();
    const Extent all = build_packing_scene(packing, options.mu, whole).extent;
    throw InputError("no contact lies in --window {}; they reach over {:.4g},{:.4g},{:.4g},{:.4g} (y counts upwards)",
                     options.window, all.x0, all.x1, -all.z1, 0 - all.z0);
  }
  render_scene(scene, options.scene, options.image.path, metadata);
  const auto pulling = std::ranges::count_if(packing.contacts, [](const auto& one) { return one.placed && one.N < 0; });
  const auto lost = std::ranges::count(packing.contacts, false, &PackingContact::placed);
  context.wrote(
      options.image.path,
      fmt::format(": {} drawn, {} outside, {} too faint to be seen{}{}", how_many(scene.counts.drawn, "contact"),
                  scene.counts.outside - static_cast<std::size_t>(lost), scene.counts.too_faint,
                  lost > 0 ? fmt::format("; not drawn without a place: {}", lost) : "",
                  pulling > 0 ? fmt::format("; counted as 0, since N < 0 there: {}", pulling) : ""));
}

void draw_film(const PackingSource& source, ContactsOptions options, VerbContext& context) {
  options.scene.backend = "none";
  options.film.force = options.image.force;
  options.film.inputs = {options.contacts, options.particles, options.walls};
  const PackingFilm film(source, options.mu, options.scene);
  write_film(
      options.film, film.frames(), false, how_many(film.frames(), "frame"),
      [&](std::size_t frame) {
        render_scene(film.scene(frame), film.spec(), std::filesystem::path(options.film.folder) / Film::name_of(frame),
                     metadata_of(options));
      },
      context);
}

ExitCode show_contacts(ContactsOptions options, VerbContext& context) {
  SceneSpec& scene = options.scene;
  scene.coordinates = Coordinates::packing;
  apply_page(options.page, scene, context);
  if (!options.range.empty()) scene.range = parse_range(options.range);
  if (std::array<double, 4> window{}; !options.window.empty()) {
    if (!parse_numbers(options.window, window)) {
      throw InputError("--window {} is not X0,X1,Y0,Y1 in mean particle diameters", options.window);
    }
    scene.window = window;
  }
  if (options.transparent) scene.background = Background::transparent;
  if (options.has_mu && !(options.mu >= 0 && std::isfinite(options.mu))) {
    throw InputError("--mu is a friction coefficient: give a number from 0 on");
  }
  std::array<fs::path, 3> written{options.image.path, options.histogram, options.on_particles};
  for (fs::path& one : written) one = one.lexically_normal();
  for (const fs::path& one : written) {
    if (!one.empty() && std::ranges::count(written, one) > 1)
      throw InputError("two files have the name {}", one.string());
  }
  for (const auto& period : {options.period_x, options.period_y}) {
    if (period && !(*period > 0 && std::isfinite(*period))) throw InputError("a period of the box is a length above 0");
  }
  require_suffix(options.histogram, ".csv");
  require_suffix(options.on_particles, ".csv");
  const std::vector<fs::path> inputs{options.contacts, options.particles, options.walls};
  if (options.image.asked()) {
    require_known_format(options.image.path);
    options.image.require_free(inputs);
  }
  const PackingSource source({options.contacts,
                              options.particles,
                              options.walls,
                              options.columns,
                              options.particle_columns,
                              options.wall_columns,
                              {options.period_x, options.period_y}});
  if (!options.film.folder.empty()) {
    draw_film(source, std::move(options), context);
    return ExitCode::done;
  }
  const Packing packing = source.read(options.step);
  for (const std::string& told : packing.told) context.err << single_line(told) << '\n';
  if (packing.steps > 1 && packing.step && !options.step) {
    context.err << fmt::format("step {:g} is taken, of {}; --step takes another\n", *packing.step, packing.steps);
  }
  const bool force = options.image.force, histogram = !options.histogram.empty(), sums = !options.on_particles.empty();
  const std::array<std::pair<OutputFile, std::string>, 2> tables{
      {{{options.histogram, force}, histogram ? histogram_of(packing, options) : ""},
       {{options.on_particles, force}, sums ? particles_table(packing) : ""}}};
  for (const auto& [file, text] : tables) file.require_free(inputs, text);  // before anything is written
  auto numbers = std::async([&] { return packing_numbers(packing, options.mu); });
  if (options.image.asked()) draw(packing, options, context);
  for (const auto& [file, text] : tables) {
    if (!file.asked()) continue;
    file.write(text, inputs);
    context.wrote(file.path);
  }
  context.out << numbers_text(numbers.get(), options.json);
  return ExitCode::done;
}

}  // namespace

void add_contacts_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "contacts",
      "Tell the statistics of somebody's contact forces (LAMMPS, LIGGGHTS, YADE, PeGS, VTK, tables), and draw them");
  verb->footer("Exit status: as granuscope --help says. Lengths and forces have the units of the file.");
  const auto options = std::make_shared<ContactsOptions>();
  verb->add_option("FILE", options->contacts,
                   "contacts: a `dump local` of LAMMPS or LIGGGHTS, a table with names of columns, PeGS' adjacency "
                   "list, or lines with arrays of cells in a file of VTK (.vtu, .vtp, .vtk)")
      ->required();
  add_output(*verb, "IMAGE,-o,--image", options->image, "draw the contacts, too: .png, .svg or .pdf");
  verb->add_option(
      "--particles", options->particles,
      "particles, where contacts name them by number only or radii are to be seen: `dump custom`, a table, PeGS' "
      "positions, or points in a file of VTK");
  listed(verb->add_option(
      "--columns", options->columns,
      "names of the columns of FILE, with commas between, where it has none or others, or NAME=COLUMN for some; known "
      "are " +
          known_contact_columns() +
          "; any other name is left alone. N > 0 presses; T > 0 turns the force on the second particle, pushed "
          "along the line from the first, to the left (y up)"));
  listed(verb->add_option("--particle-columns", options->particle_columns,
                          "the same of --particles; known are " + known_particle_columns()));
  verb->add_option(
      "--walls", options->walls,
      "contacts with walls, where they stand apart (`compute wall/gran/local` of LIGGGHTS, `fix wall/gran` "
      "of LAMMPS with `contacts`)");
  listed(verb->add_option("--wall-columns", options->wall_columns, "the same of --walls"))->needs("--walls");
  verb->add_option("--step", options->step, "of a dump, or `frame` of a table (the last if not given)");
  verb->add_option("--period-x", options->period_x, "of the box, where a dump does not say it, lengths of the file");
  verb->add_option("--period-y", options->period_y, "the same in y");
  verb->add_option("--mu", options->mu, "friction coefficient, for sliding contacts and violations of |T| <= mu N");
  verb->add_flag("--json", options->json, "the numbers as one JSON object");
  verb->add_option("--histogram", options->histogram, "CSV file to write: how often --of has a value, with errors");
  verb->add_option("--of", options->of,
                   "N (over its mean), friction (|T|/(mu N), without --mu |T|/N) or direction (degrees from x)")
      ->capture_default_str()
      ->check(CLI::IsMember({"N", "friction", "direction"}));
  verb->add_option("--on-particles", options->on_particles,
                   "CSV file to write: contacts, sum of forces and torque of each particle");
  verb->add_option("--scene", options->scene.scene,
                   "forces: N over its mean, with --mu a dot on those that slide; friction: |T|/(mu N)")
      ->capture_default_str();
  add_page_options(*verb, options->page, "width of the picture: 1600 (pixels), 86mm, 8.6cm or 3.37in");
  verb->add_option("--dpi", options->scene.dpi, "pixels per inch; text is laid out in points")->capture_default_str();
  verb->add_option("--window", options->window, "X0,X1,Y0,Y1 in mean particle diameters (all if not given)");
  verb->add_option("--range", options->range, "LOW,HIGH: ends of the colour scale (from the forces if not given)");
  options->scene.colour_map.clear();
  options->scene.backend = "none";
  verb->add_option("--colour-map", options->scene.colour_map, "grey, viridis or cividis (the scene's own if not given)")
      ->transform(CLI::detail::to_lower);
  verb->add_option("--backend", options->scene.backend,
                   "none: the processor paints, the quickest for thin bars; auto, osmesa or egl: to the same pixels")
      ->capture_default_str();
  verb->add_flag("--transparent", options->transparent, "no page behind the picture");
  verb->add_option("--film", options->film.folder,
                   "folder: instead of all else a picture of each step, in one window with one colour scale");
  verb->add_option("-j,--threads", options->film.threads, "of a film: threads, 0 for all; never changes a pixel")
      ->needs("--film")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->callback([options, verb] {
    if (!options->film.folder.empty()) {
      for (const char* flag : {"--image", "--histogram", "--on-particles", "--json", "--step", "--backend"}) {
        if (verb->count(flag) == 0) continue;
        throw CLI::ValidationError(
            fmt::format("{} has no meaning for a film, which shows all steps; leave it out", flag));
      }
      if (verb->count("--width") == 0) options->scene.width_px = film_width_px;
      if (verb->count("--dpi") == 0) options->scene.dpi = film_dpi;
    }
    options->has_mu = verb->count("--mu") > 0;
  });
  context.actions[verb] = [options, &context] { return show_contacts(*options, context); };
}

}  // namespace granuscope
