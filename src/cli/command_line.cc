#include "cli/command_line.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/verbs.h"
#include "experiment/nearest_name.h"
#include "support/error.h"
#include "support/interruption.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

constexpr const char* exit_codes =
    "Exit status: 0 all was made; 1 a claim came out otherwise than expected (only with --gate); 2 the command line,\n"
    "the experiment or a file cannot be used; 3 the machine lacks a program, OpenGL, space or permission; 4 "
    "interrupted:\n"
    "the same command goes on. Lengths are in bead diameters, forces in loads of one top bead.";

/// CLI11 would only say that a verb is missing, not that the one given is none.
void require_known_verb(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_name() == argv[1]) return;
    if (!verb->get_group().empty()) verbs.push_back(verb->get_name());
  }
  const auto meant = nearest_name(argv[1], verbs);
  throw InputError(fmt::format(
      "there is no verb \"{}\"; {}", argv[1],
      meant ? fmt::format("did you mean {}?", *meant) : fmt::format("the verbs are {}", fmt::join(verbs, ", "))));
}

ExitCode parse_and_act(int argc, const char* const* argv, std::ostream& out, std::ostream& err) {
  CLI::App app{
      "Random force networks of frictional beads: how a point load spreads through them, in numbers, pictures and "
      "one report.",
      "granuscope"};
  app.footer(exit_codes);
  app.require_subcommand(1);
  app.set_version_flag("--version", [] { return provenance_line(collect_provenance()); });
  VerbContext context{out, err, {}};
  add_run_verb(app, context);
  add_sample_verb(app, context);
  add_render_verb(app, context);
  add_audit_verb(app, context);
  add_doctor_verb(app, context);
  add_reference_verb(app, context);

  require_known_verb(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      app.exit(error, out, err);
      return ExitCode::done;
    }
    std::string verb;
    for (const CLI::App* chosen : app.get_subcommands()) verb = " " + chosen->get_name();
    throw InputError(fmt::format("{}; granuscope{} --help lists what can be written here", error.what(), verb));
  }
  install_interruption_handlers();
  const ExitCode code = context.action();
  out.flush();
  if (!out)
    throw EnvironmentError(
        "standard output cannot be written, so that the result is lost; free space or check the pipe");
  return code;
}

}  // namespace

int run_command_line(int argc, const char* const* argv, std::ostream& out, std::ostream& err) {
  // The one place where errors become an exit status.
  ExitCode code = ExitCode::environment;
  std::string message;
  try {
    return static_cast<int>(parse_and_act(argc, argv, out, err));
  } catch (const Error& error) {
    code = error.exit_code();
    message = error.what();
  } catch (const std::bad_alloc&) {
    message = "there is not enough memory for this; make the pile smaller or use fewer --threads";
  } catch (const std::length_error&) {
    message = "this is larger than any memory; make the pile smaller";
  } catch (const std::exception& error) {
    message = fmt::format("a fault of the program, not of the input: {}; please report it with the command line",
                          error.what());
  }
  err << "granuscope: " << message << '\n';
  err.flush();
  return static_cast<int>(code);
}

}  // namespace granuscope
