#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/flag_checks.h"
#include "cli/verbs.h"
#include "report/pack.h"

namespace granuscope {
namespace {

struct PackVerbOptions {
  std::string folder, citation;
  OutputFile archive;
  bool with_ensembles = false;
};

ExitCode pack(const PackVerbOptions& given, VerbContext& context) {
  given.archive.require_free({given.folder, given.citation});
  PackOptions options;
  options.with_ensembles = given.with_ensembles;
  constexpr const char* beside = "CITATION.cff";
  std::error_code none;
  if (!given.citation.empty()) {
    options.citation = read_citation(given.citation);
  } else if (std::filesystem::is_regular_file(beside, none)) {
    options.citation = read_citation(beside);
  } else {
    context.err << "there is no CITATION.cff here, so that the archive names no authors and no licence (--citation)\n";
  }
  const std::size_t files = pack_run(given.folder, given.archive.path, options);
  context.err << fmt::format("wrote {} with {} files\n", given.archive.path, files);
  return ExitCode::done;
}

}  // namespace

void add_pack_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "pack", "Pack a finished run into one archive, a research object (RO-Crate 1.1) to be kept and passed on");
  const auto options = std::make_shared<PackVerbOptions>();
  verb->add_option("OUT", options->folder, "folder of the run")->required();
  add_output(*verb, "-o,--out", options->archive, "archive to write (zip)")->required();
  verb->add_option("--citation", options->citation,
                   "CITATION.cff whose authors and licence the archive is to name (default: the one in this folder)");
  verb->add_flag("--with-ensembles", options->with_ensembles,
                 "with all that was drawn, so that whoever unpacks it can go on from there");
  verb->callback([options, &context] { context.action = [options, &context] { return pack(*options, context); }; });
}

}  // namespace granuscope
