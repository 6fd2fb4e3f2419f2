#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/verbs.h"
#include "pipeline/merge_folders.h"

namespace granuscope {

void add_merge_verb(CLI::App& app, VerbContext& context) {
  struct Options {
    std::vector<std::string> folders;
    std::string out;
  };
  CLI::App* verb = app.add_subcommand("merge", "Join what the shards of an experiment have drawn (run --shard)");
  const auto options = std::make_shared<Options>();
  verb->add_option("DIR", options->folders, "folders in which shards have worked, in any order")->required();
  verb->add_option("-o,--out", options->out, "folder of the whole ensembles (default: the first DIR)");
  verb->callback([options, &context] {
    context.action = [options, &context] {
      const std::filesystem::path out = options->out.empty() ? options->folders.front() : options->out;
      merge_folders({options->folders.begin(), options->folders.end()}, out, ProgressStyle::automatic);
      context.err << fmt::format("merged into {}; granuscope run {} --out {} goes on to the report\n", out.string(),
                                 (out / "experiment.toml").string(), out.string());
      return ExitCode::done;
    };
  });
}

}  // namespace granuscope
