#pragma once
#include <functional>
#include <map>
#include <ostream>
#include <string>

#include "support/error.h"

namespace CLI {
class App;
}

namespace granuscope {

class Crew;

/// What a verb is given, and what it does once the whole command line has been understood.
struct VerbContext {
  std::ostream& out;                                             ///< results
  std::ostream& err;                                             ///< messages
  std::map<const CLI::App*, std::function<ExitCode()>> actions;  ///< of each verb
  Crew* crew = nullptr;  ///< other processes that draw with this one (granuscope-mpi)

  /// Says that a file is there, on one line that moves no cursor whatever its name holds; `how`: what follows.
  void wrote(const std::string& file, const std::string& how = "") const;
};

/// The listed verb of that name. Throws InputError, with what was probably meant, if there is none.
const CLI::App& verb_named(const CLI::App& app, const std::string& name);

/// What stands here for a flag or a verb of other programs: templates/hints.txt; "" if it is none.
std::string hint_for(const std::string& word);

/// Each adds one verb with its flags to the command line, and what it does to context.actions.
void add_run_verb(CLI::App& app, VerbContext& context);
void add_new_verb(CLI::App& app, VerbContext& context);
void add_merge_verb(CLI::App& app, VerbContext& context);
void add_sample_verb(CLI::App& app, VerbContext& context);
void add_render_verb(CLI::App& app, VerbContext& context);
void add_export_verb(CLI::App& app, VerbContext& context);
void add_contacts_verb(CLI::App& app, VerbContext& context);
void add_audit_verb(CLI::App& app, VerbContext& context);
void add_compare_verb(CLI::App& app, VerbContext& context);
void add_nightly_verb(CLI::App& app, VerbContext& context);
void add_history_verb(CLI::App& app, VerbContext& context);
void add_bench_verb(CLI::App& app, VerbContext& context);
void add_doctor_verb(CLI::App& app, VerbContext& context);
void add_figure_verb(CLI::App& app, VerbContext& context);
void add_numbers_verb(CLI::App& app, VerbContext& context);
void add_pack_verb(CLI::App& app, VerbContext& context);
void add_article_verb(CLI::App& app, VerbContext& context);
void add_example_verb(CLI::App& app, VerbContext& context);
void add_explain_verb(CLI::App& app, VerbContext& context);
void add_help_verb(CLI::App& app, VerbContext& context);       ///< and version
void add_reference_verb(CLI::App& app, VerbContext& context);  ///< keys, man pages, completions

}  // namespace granuscope
