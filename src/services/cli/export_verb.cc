#include "cli/flag_checks.h"
#include "export/field_export.h"
#include "export/pile_export.h"
#include "plot/response_field.h"
#include "storage/pile_file.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

constexpr Names<PileFormat, 5> pile_formats = {{{PileFormat::vtu, "vtu"},
                                                {PileFormat::dump_local, "dump-local"},
                                                {PileFormat::pegs, "pegs"},
                                                {PileFormat::graphml, "graphml"},
                                                {PileFormat::csv, "csv"}}};
constexpr Names<FieldFormat, 2> field_formats = {{{FieldFormat::vti, "vti"}, {FieldFormat::csv, "csv"}}};
constexpr Names<NetworkPart, 3> parts = {
    {{NetworkPart::contacts, "contacts"}, {NetworkPart::beads, "beads"}, {NetworkPart::walls, "walls"}}};

/// Suffixes that stand for a format; that of tables for PeGS2, .txt, does not.
constexpr SuffixOfFormat suffixes[] = {{".vtu", "vtu"},   {".local", "dump-local"}, {".dump", "dump-local"},
                                       {".pegs", "pegs"}, {".graphml", "graphml"},  {".csv", "csv"},
                                       {".vti", "vti"}};

struct ExportOptions {
  std::string source, format, part;
  OutputFile file;
};

template <class Format, std::size_t count>
Format chosen(const Names<Format, count>& formats, const std::string& format, const std::string& file,
              const char* kind) {
  for (const auto& [one, name] : formats) {
    if (name == format) return one;
  }
  throw InputError("{} is {}, which can be exported as {}, not as {}", file, kind, all_names(formats), format);
}

/// What the file says of itself. It names no folder: the same pile gives the same bytes anywhere.
std::string origin_of(const std::string& source) {
  return fmt::format("{}, granuscope export of {}", provenance_line(collect_provenance()),
                     single_line(std::filesystem::path(source).filename().string()));
}

void export_ensemble(const ExportOptions& options, const std::string& format, const std::string& configuration,
                     const Accept& accept) {
  const FieldFormat wanted = chosen(field_formats, format, options.source, "an ensemble");
  if (!options.part.empty()) {
    throw InputError("{} is an ensemble, which has neither beads nor contacts; leave out --part", options.source);
  }
  export_field(open_response(options.source, configuration), wanted, options.file.path, origin_of(options.source),
               accept);
}

/// What the file cannot say of the pile.
std::string export_pile_file(const ExportOptions& options, const std::string& format, const Accept& accept) {
  // Whether it is a pile is asked first: of another file no format fits.
  const auto layers = open_pile_layers(options.source, whole_range);
  const PileView& pile = layers->about();
  PileExport what;
  what.format = chosen(pile_formats, format, options.source, "a pile");
  if (!options.part.empty()) what.part = named_in(parts, options.part, "part");
  if (!options.part.empty() && !has_part(what.format, what.part)) {
    throw InputError("a file of the format {} has {}; leave out --part", format,
                     what.part == NetworkPart::walls && what.format != PileFormat::graphml
                         ? "contacts with the floor among the others"
                         : "beads and contacts");
  }
  what.origin = fmt::format("{}: {} columns x {}, mu {}, law {}, seed {}, sample {}", origin_of(options.source),
                            pile.lattice.columns(), how_many(pile.lattice.layers(), "layer"), exact(pile.mu),
                            single_line(pile.law), pile.seed, pile.sample);
  export_pile(*layers, what, options.file.path, accept);
  return lost_in(layers->about(), what);
}

ExitCode export_file(const ExportOptions& options, VerbContext& context) {
  const std::string format = format_by_name(options.file.path, options.format, suffixes, true);
  const Accept accept = [&](std::string_view begins) { options.file.require_free({options.source}, begins); };
  std::string lost;
  try {
    const std::string configuration = configuration_if_ensemble(options.source);
    if (configuration.empty()) {
      lost = export_pile_file(options, format, accept);
    } else {
      export_ensemble(options, format, configuration, accept);
    }
  } catch (const Interrupted&) {
    throw Interrupted("stopped on request: no file was written, and the same command writes it from the start");
  }
  context.wrote(options.file.path);
  if (!lost.empty()) context.err << lost << '\n';
  return ExitCode::done;
}

}  // namespace

void add_export_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "export", "Write a stored pile, or the mean response of an ensemble, for other programs: ParaView, OVITO, ...");
  const auto options = std::make_shared<ExportOptions>();
  verb->add_option("FILE", options->source,
                   "pile file (HDF5), as granuscope sample --out writes it, or ensemble file, as a run leaves it")
      ->required();
  verb->add_option("--format", options->format,
                   "of a pile: vtu (ParaView), dump-local (LAMMPS, LIGGGHTS, OVITO), pegs (PeGS2), graphml (NetworkX, "
                   "Gephi) or csv; of an ensemble: vti (ParaView) or csv (by the file's suffix if not given)")
      ->transform(CLI::detail::to_lower);
  verb->add_option("--part", options->part,
                   "contacts or beads: what a file of the formats dump-local, pegs and csv holds, which keep them "
                   "apart (contacts if not given); of dump-local walls, too: the contacts on the floor");
  add_output(*verb, "OUTPUT,-o,--out", options->file, "file to write")->required();
  context.actions[verb] = [options, &context] { return export_file(*options, context); };
}

}  // namespace granuscope
