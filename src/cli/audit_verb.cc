#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/verbs.h"
#include "model/audit.h"
#include "report/statistics_json.h"
#include "storage/pile_file.h"

namespace granuscope {
namespace {

// Rounding leaves some 1e-15 on piles of a million beads; anything beyond this is no solution.
constexpr double audit_tolerance = 1e-12;

ExitCode audit_file(const std::string& file, bool json, VerbContext& context) {
  const Pile pile = read_pile(file);
  const AuditResult result = audit(pile);
  const std::string text = fmt::format(
      "{} columns x {} layers, mu {}, law {}, seed {}, sample {}\n"
      "largest balance residual  {:.3g}  (layer {})\n"
      "largest cone violation    {:.3g}  (layer {})\n"
      "both relative to the largest contact force of the same layer; allowed: {:g}\n",
      pile.lattice.columns(), pile.lattice.layers(), pile.mu, pile.law, pile.seed, pile.sample,
      result.max_balance_residual, result.balance_layer, result.max_cone_violation, result.cone_layer, audit_tolerance);
  context.out << (json ? audit_json(pile, result, audit_tolerance) : text);
  if (result.max_balance_residual <= audit_tolerance && result.max_cone_violation <= audit_tolerance) {
    return ExitCode::done;
  }
  throw InputError(
      fmt::format("{}: this is no equilibrium of frictional beads, since a residual exceeds {:g}; whatever "
                  "wrote the file is wrong, or the file was changed",
                  file, audit_tolerance));
}

}  // namespace

void add_audit_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "audit", "Recompute every balance and every friction cone of a stored pile, in normal and tangential components");
  const auto file = std::make_shared<std::string>();
  verb->add_option("FILE", *file, "pile file (HDF5), as granuscope sample --out writes it")->required();
  const auto json = std::make_shared<bool>(false);
  verb->add_flag("--json", *json, "print one JSON object on standard output and nothing else there");
  verb->callback([file, json, &context] {
    context.action = [file, json, &context] { return audit_file(*file, *json, context); };
  });
}

}  // namespace granuscope
