#include <optional>

#include "cli/flag_checks.h"
#include "history/comparison.h"
#include "model/audit.h"
#include "pipeline/run_folder.h"
#include "pipeline/shards.h"
#include "report/article.h"
#include "report/citation.h"
#include "report/clean_json.h"
#include "report/number_text.h"
#include "report/run_files.h"
#include "storage/pile_file.h"

namespace granuscope {
namespace {

// Rounding leaves some 1e-15 on piles of a million beads; anything beyond this is no solution.
constexpr double audit_tolerance = 1e-12;

ExitCode audit_file(const std::string& file, bool json, VerbContext& context) {
  const Pile pile = read_pile(file);
  const AuditResult result = audit(pile);
  const std::string text = fmt::format(
      "{} columns x {}, mu {}, law {}, seed {}, sample {}\n"
      "largest balance residual  {:.3g}  (layer {})\n"
      "largest cone violation    {:.3g}  (layer {})\n"
      "both relative to the largest contact force of the same layer; allowed: {:g}\n",
      pile.lattice.columns(), how_many(pile.lattice.layers(), "layer"), pile.mu, single_line(pile.law), pile.seed,
      pile.sample, result.max_balance_residual, result.balance_layer, result.max_cone_violation, result.cone_layer,
      audit_tolerance);
  context.out << (json ? audit_json(pile, result, audit_tolerance) : text);
  if (result.max_balance_residual <= audit_tolerance && result.max_cone_violation <= audit_tolerance) {
    return ExitCode::done;
  }
  throw InputError(
      "{}: this is no equilibrium of frictional beads, since a residual exceeds {:g}; whatever wrote the file is "
      "wrong, or the file was changed",
      file, audit_tolerance);
}

}  // namespace

void add_audit_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "audit", "Recompute every balance and every friction cone of a stored pile, in normal and tangential components");
  const auto file = std::make_shared<std::string>();
  verb->add_option("FILE", *file, "pile file (HDF5), as granuscope sample --out writes it")->required();
  const auto json = std::make_shared<bool>(false);
  verb->add_flag("--json", *json, "print one JSON object on standard output and nothing else there");
  context.actions[verb] = [file, json, &context] { return audit_file(*file, *json, context); };
}

void add_merge_verb(CLI::App& app, VerbContext& context) {
  struct Options {
    std::vector<std::string> folders;
    std::string out;
  };
  CLI::App* verb = app.add_subcommand("merge", "Join what the shards of an experiment have drawn (run --shard)");
  const auto options = std::make_shared<Options>();
  verb->add_option("DIR", options->folders, "folders in which shards have worked, in any order")->required();
  verb->add_option("-o,--out", options->out, "folder of the whole ensembles (default: the first DIR)");
  context.actions[verb] = [options, &context] {
    const std::filesystem::path out = options->out.empty() ? options->folders.front() : options->out;
    require_no_history(out);
    const bool joined =
        merge_folders({options->folders.begin(), options->folders.end()}, out, ProgressStyle::automatic);
    context.err << fmt::format("{} {}; granuscope run {} --out {} goes on to the report\n",
                               joined ? "merged into" : "nothing was to be joined for", single_line(out.string()),
                               shell_word((out / "experiment.toml").string()), shell_word(out.string()));
    return ExitCode::done;
  };
}

void add_numbers_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "numbers", "Print the numbers of a finished run, with their standard errors, for the text of a paper");
  const auto folder = std::make_shared<std::string>();
  const auto format = std::make_shared<std::string>();
  verb->add_option("OUT", *folder, "folder of the run, or its summary.json")->required();
  verb->add_option("--format", *format,
                   "tex (\\granuscope{mu-0.3/c} writes 0.56026(50)), csv or json (by the file's suffix, or tex)")
      ->transform(CLI::detail::to_lower);
  const auto choice = std::make_shared<NumberChoice>();
  verb->add_flag("--all", choice->all,
                 "every number of the run, thousands of them; without it c, D, c_thrust, the exponents and what the "
                 "claims are judged by");
  listed(verb->add_option(
      "--only", choice->only,
      "NAME,NAME: those of this name, or with it between the strokes of theirs, as c,D or mu-0.3/c or beta"));
  const auto target = std::make_shared<OutputFile>();
  add_output(*verb, "-o,--out", *target, "file to write (standard output if not given)");
  context.actions[verb] = [folder, format, choice, target, &context] {
    constexpr std::array<SuffixOfFormat, 3> known = {{{".tex", "tex"}, {".csv", "csv"}, {".json", "json"}}};
    if (target->asked()) *format = format_by_name(target->path, *format, known, true);
    if (format->empty()) *format = "tex";
    if (std::filesystem::path(*folder).filename() == "summary.json")
      *folder = (std::filesystem::path(*folder).parent_path() / ".").string();  // as compare takes it
    require_results_of_last_run(*folder, "report");
    const auto file = std::filesystem::path(*folder) / "summary.json";
    if (!file_exists(file)) {
      throw InputError(file.string() + ": there is no such file, and so no numbers; name the folder of a finished run");
    }
    require_unchanged(*folder, "summary.json");
    const std::string list = list_numbers(read_json(file), *format, *choice);
    if (!target->asked()) {
      context.out << list;
    } else {
      target->write(list, {*folder});
      context.wrote(target->path);
    }
    return ExitCode::done;
  };
}

namespace {

/// Names the one in this folder where none is named; none where neither is.
std::optional<Citation> citation_in(std::string& file) {
  if (file.empty() && file_exists("CITATION.cff")) file = "CITATION.cff";
  return file.empty() ? std::nullopt : std::optional(read_citation(file));
}

std::string named_by(const std::optional<Citation>& citation) {
  if (!citation) return "; it names no authors and no licence, since no CITATION.cff is here (--citation)";
  return fmt::format("; by CITATION.cff it names {}{}{}", citation->authors.front().name,
                     citation->authors.size() > 1 ? " and others" : "",
                     citation->licenses.empty() ? "" : fmt::format(", {}", fmt::join(citation->licenses, " or ")));
}

struct PackVerbOptions {
  std::string folder, citation, sources;
  OutputFile archive;
  bool with_ensembles = false;
};

ExitCode pack(PackVerbOptions& given, VerbContext& context) {
  require_suffix(given.archive.path, ".zip");
  PackOptions options;
  options.with_ensembles = given.with_ensembles;
  options.sources = given.sources;
  options.citation = citation_in(given.citation);
  given.archive.require_free({given.folder, given.citation});
  const std::size_t files = pack_run(given.folder, given.archive.path, options);
  context.wrote(given.archive.path, fmt::format(" with {} files{}", files, named_by(options.citation)));
  return ExitCode::done;
}

}  // namespace

void add_pack_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "pack", "Pack a finished run into one archive, a research object (Process Run Crate) to be kept and passed on");
  const auto options = std::make_shared<PackVerbOptions>();
  verb->add_option("OUT", options->folder, "folder of the run")->required();
  add_output(*verb, "ARCHIVE,-o,--out", options->archive, "archive to write (zip)")->required();
  verb->add_option("--citation", options->citation,
                   "CITATION.cff whose authors and licence the archive is to name (default: the one in this folder)");
  verb->add_flag("--with-ensembles", options->with_ensembles,
                 "with all that was drawn, so that whoever unpacks it can go on from there");
  verb->add_option("--with-sources", options->sources,
                   "a clone of the program's repository: with the sources of the commit that made the run");
  context.actions[verb] = [options, &context] { return pack(*options, context); };
}

void add_article_verb(CLI::App& app, VerbContext& context) {
  struct Options {
    std::string folder, target, citation;
  };
  CLI::App* verb = app.add_subcommand(
      "article",
      "Write the skeleton of an article that replicates the paper (ReScience C) from a finished run, in LaTeX");
  const auto options = std::make_shared<Options>();
  verb->add_option("OUT", options->folder, "folder of the run")->required();
  verb->add_option("FOLDER,-o,--out", options->target, "new folder for the article")->required();
  verb->add_option("--citation", options->citation,
                   "CITATION.cff whose authors the article is to name (default: the one in this folder)");
  context.actions[verb] = [options, &context] {
    const std::optional<Citation> citation = citation_in(options->citation);
    write_article(options->folder, options->target, citation);
    context.wrote(options->target, fmt::format(", where pdflatex article.tex sets the article{}", named_by(citation)));
    return ExitCode::done;
  };
}

namespace {

struct CompareVerbOptions {
  std::string before, after;
  OutputFile json;
  bool gate = false;
};

ExitCode compare(const CompareVerbOptions& given, VerbContext& context) {
  require_suffix(given.json.path, ".json");
  if (given.json.asked()) require_writable(given.json.path);
  const Comparison comparison = compare_runs(given.before, given.after);
  for (const std::string& line : describe(comparison)) context.out << line << '\n';
  if (given.json.asked()) given.json.write(json_text(comparison), {given.before, given.after});
  const bool comparable = comparison.likeness != Likeness::other_experiment;
  return given.gate && (!comparable || comparison.alarms()) ? ExitCode::verdict_differs : ExitCode::done;
}

}  // namespace

void add_compare_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb =
      app.add_subcommand("compare",
                         "Compare two runs: same numbers, same experiment, other samples of it, or another one. Ends "
                         "with 0, whatever it finds, unless --gate is given; with 2 if there is nothing to compare");
  const auto options = std::make_shared<CompareVerbOptions>();
  verb->add_option("OLD", options->before, "folder of a run, or its summary.json")->required();
  verb->add_option("NEW", options->after, "folder of another run, or its summary.json")->required();
  add_output(*verb, "--json", options->json, "file for the answer as JSON, every number with it");
  verb->add_flag("--gate", options->gate,
                 "end with status 1 if the same experiment has other numbers beyond rounding, if a number moved "
                 "between samples, or if the experiments cannot be compared");
  context.actions[verb] = [options, &context] { return compare(*options, context); };
}

}  // namespace granuscope
