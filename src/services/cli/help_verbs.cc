#include "cli/help_verbs.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "cli/flag_checks.h"
#include "experiment/experiment.h"
#include "experiment/experiment_file.h"
#include "report/page_overlays.h"
#include "support/plain_text.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {
namespace {

/// What somebody may have meant who wrote a file where a verb belongs; "" if it is none.
std::string verb_for_file(const std::string& word) {
  if (word.ends_with(".toml")) return "run " + word;
  if (word.ends_with(".h5")) return "render " + word;
  return file_exists(word) ? "run " + word : "";
}

}  // namespace

const CLI::App& verb_named(const CLI::App& app, const std::string& name) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_name() == name) return *verb;
    if (!verb->get_group().empty()) verbs.push_back(verb->get_name());
  }
  const auto told = [&]() -> std::string {
    if (const std::string command = verb_for_file(name); !command.empty()) {
      return fmt::format("did you mean: granuscope {}?", command);
    }
    const auto meant = nearest_name(name, verbs);
    return meant ? fmt::format("did you mean {}?", *meant) : fmt::format("the verbs are {}", fmt::join(verbs, ", "));
  };
  throw InputError("there is no verb \"{}\"; {}", name, told());
}

void add_help_verb(CLI::App& app, VerbContext& context) {
  CLI::App* help = app.add_subcommand("help", "Print what this program, or one of its verbs, can be asked for");
  const auto verb = std::make_shared<std::string>();
  help->add_option("VERB", *verb, "the verb (all of them in short if not given)");
  context.actions[help] = [verb, &app, &context] {
    // app.help() would be that of the verb help.
    const auto formatter = app.get_formatter();
    context.out << (verb->empty() ? formatter->make_help(&app, "granuscope", CLI::AppFormatMode::Normal)
                                  : verb_named(app, *verb).help("granuscope"));
    return ExitCode::done;
  };
  CLI::App* version = app.add_subcommand("version", "Print the version, as --version does");
  version->group("");  // not listed: the flag is
  context.actions[version] = [&context] {
    context.out << provenance_line(collect_provenance()) << '\n';
    return ExitCode::done;
  };
}

namespace {

constexpr std::string_view examples_folder = "examples/";
constexpr std::string_view extension = ".toml";

std::vector<std::string> names_of_examples() {
  std::vector<std::string> names;
  for (const EmbeddedFile& file : embedded_files()) {
    if (!file.name.starts_with(examples_folder)) continue;
    const std::string_view name = file.name.substr(examples_folder.size());
    names.emplace_back(name.substr(0, name.size() - extension.size()));
  }
  return names;
}

std::string text_of_example(const std::string& name) {
  return std::string(template_file(fmt::format("{}{}{}", examples_folder, name, extension)));
}

ExitCode print_example(std::string name, VerbContext& context) {
  const std::vector<std::string> names = names_of_examples();
  if (name.empty()) {
    std::size_t width = 0;
    for (const std::string& known : names) width = std::max(width, known.size());
    for (const std::string& known : names) {
      const Experiment experiment = parse_experiment(text_of_example(known), known, {}, EmptyFile::allowed, known);
      context.out << fmt::format("{:<{}}  {}\n", known, width, experiment.name);
    }
    context.err << "granuscope example quick >quick.toml    writes one of them, and\n"
                   "granuscope run quick.toml               makes its report in out/quick\n";
    return ExitCode::done;
  }
  if (name.ends_with(extension)) name.resize(name.size() - extension.size());
  if (std::ranges::find(names, name) == names.end()) {
    const auto meant = nearest_name(name, names);
    throw InputError("there is no example {}; {}built in are {}", name,
                     meant ? fmt::format("did you mean {}? ", *meant) : "", fmt::join(names, ", "));
  }
  context.out << text_of_example(name);
  return ExitCode::done;
}

}  // namespace

void add_example_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("example", "Print a built-in experiment, to be run or changed");
  const auto name = std::make_shared<std::string>();
  verb->add_option("NAME", *name, "which one, for example quick (a list if not given)");
  context.actions[verb] = [name, &context] { return print_example(*name, context); };
}

namespace {

/// The entries of a word: of that name as it is written, or but for small letters and a plural.
std::vector<GlossaryEntry> meanings_of(const std::string& word, const std::vector<GlossaryEntry>& all) {
  std::vector<GlossaryEntry> exact, near;
  for (const GlossaryEntry& entry : all) {
    const auto is = [&](const auto& same) { return std::ranges::any_of(entry.names, same); };
    const std::string small = lower_case(word), one = small.ends_with('s') ? small.substr(0, small.size() - 1) : small;
    if (is([&](const std::string& name) { return name == word; })) exact.push_back(entry);
    if (is([&](const std::string& name) { return lower_case(name) == small || lower_case(name) == one; }))
      near.push_back(entry);
  }
  return exact.empty() ? near : exact;
}

ExitCode explain_word(const std::string& word, VerbContext& context) {
  const std::vector<GlossaryEntry> all = glossary();
  if (word.empty()) {
    std::vector<std::string> words;
    words.reserve(all.size());
    for (const GlossaryEntry& entry : all) words.push_back(fmt::format("{}", fmt::join(entry.names, ", ")));
    context.out << fmt::format("{}\n", fmt::join(words, "\n"));
    return ExitCode::done;
  }
  const std::vector<GlossaryEntry> found = meanings_of(word, all);
  if (found.empty()) {
    std::vector<std::string> names;
    for (const GlossaryEntry& entry : all) names.insert(names.end(), entry.names.begin(), entry.names.end());
    const auto meant = nearest_name(word, names);
    throw InputError("the glossary has no word {}; {}granuscope explain lists all that it has", word,
                     meant ? fmt::format("did you mean {}? ", *meant) : "");
  }
  for (const GlossaryEntry& entry : found) {
    context.out << fmt::format("{}: {}.\n", fmt::join(entry.names, ", "), entry.text);
  }
  if (const std::string law = "law/" + lower_case(word) + ".txt"; has_template(law)) context.out << template_file(law);
  return ExitCode::done;
}

/// Several words are one name, as long a one as the glossary has, or each by itself.
ExitCode explain_words(std::vector<std::string> words, VerbContext& context) {
  if (words.empty()) return explain_word("", context);
  const std::vector<GlossaryEntry> all = glossary();
  for (std::size_t count = 0; !words.empty(); words.erase(words.begin(), words.begin() + static_cast<int>(count))) {
    const auto name = [&] {
      return fmt::format("{}", fmt::join(words.begin(), words.begin() + static_cast<int>(count), " "));
    };
    for (count = words.size(); count > 1 && meanings_of(name(), all).empty();) --count;
    explain_word(name(), context);
  }
  return ExitCode::done;
}

}  // namespace

void add_explain_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb =
      app.add_subcommand("explain", "Say what a word of the report means, such as c_thrust, pull or block");
  const auto word = std::make_shared<std::vector<std::string>>();
  verb->add_option("WORD", *word, "which one (a list if not given)");
  context.actions[verb] = [word, &context] { return explain_words(*word, context); };
}

namespace {

/// Text as one cell of a Markdown table; a bar would end the cell, even inside code.
std::string cell(const std::string& text) { return replaced(text, {{'|', "\\|"}, {'\n', " "}}); }

std::string flag_row(const CLI::Option& option) {
  const std::string type = option.get_expected_max() == 0 ? "" : option.get_type_name();
  const std::string standard = option.get_default_str();
  return fmt::format("| `{}` | {} | {} | {} |\n",
                     cell(option.nonpositional() ? option.get_name(false, true) : option.get_name(true)), cell(type),
                     standard.empty() ? "" : fmt::format("`{}`", cell(standard)), cell(option.get_description()));
}

/// A heading and a table of flags for each listed verb, from the very objects that read the command line.
std::string describe_verbs(const CLI::App& app) {
  std::string text;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_group().empty()) continue;
    text += fmt::format("### granuscope {}\n\n{}\n\n| flag | value | default | meaning |\n|---|---|---|---|\n",
                        verb->get_name(), verb->get_description());
    for (const CLI::Option* option : verb->get_options()) text += flag_row(*option);
    text += '\n';
  }
  return text;
}

}  // namespace

void add_reference_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("reference", "Print the table of experiment keys, docs/reference.md (Markdown)");
  const auto verbs = std::make_shared<bool>(false);
  const auto folder = std::make_shared<std::string>();
  verb->add_flag("--verbs", *verbs, "print every verb with its flags instead");
  verb->add_option("--files", *folder, "write manual pages and completion files below this folder (share) instead");
  context.actions[verb] = [&app, &context, verbs, folder] {
    if (!folder->empty()) {
      for (const auto& [path, text] : installed_files(app)) {
        const auto file = std::filesystem::path(*folder) / path;
        make_folder(file.parent_path());
        OutputFile{file.string()}.write(text);
      }
      return ExitCode::done;
    }
    context.out << (*verbs ? describe_verbs(app) : describe_experiment_keys());
    return ExitCode::done;
  };
}

namespace {

std::vector<const CLI::App*> listed_verbs(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

// Manual pages --------------------------------------------------------------------------------------------------------

/// Text as roff: a hyphen there is no minus, and a line must not begin as a command does.
std::string roff(std::string_view text) {
  std::string result = replaced(text, {{'-', "\\-"}, {'\\', "\\e"}});
  for (std::size_t at = 0; at < result.size(); at = std::min(result.find('\n', at), result.size() - 1) + 1) {
    if (result[at] == '.' || result[at] == '\'') result.insert(at, "\\&");
  }
  return result;
}

std::string title(std::string name, int section) {
  for (char& c : name) c = c == ' ' ? '-' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string version = provenance_line(collect_provenance());
  version.resize(std::min(version.find(','), version.size()));
  return fmt::format(".TH {} {} \"\" \"{}\" \"\"\n", roff(name), section, roff(version));
}

/// -o, --out TEXT; FILE.
std::string option_head(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back(fmt::format("\\fB\\-{}\\fR", name));
  for (const std::string& name : option.get_lnames()) names.push_back(fmt::format("\\fB\\-\\-{}\\fR", roff(name)));
  if (names.empty()) return fmt::format("\\fI{}\\fR", roff(option.get_name(true)));
  const bool takes_value = option.get_expected_max() != 0;
  return fmt::format("{}{}", fmt::join(names, ", "),
                     takes_value ? fmt::format(" \\fI{}\\fR", roff(option.get_type_name())) : "");
}

std::string option_list(const CLI::App& verb) {
  std::string text;
  for (const CLI::Option* option : verb.get_options()) {
    const std::string standard = option->get_default_str();
    text += fmt::format(".TP\n{}\n{}.{}\n", option_head(*option), roff(option->get_description()),
                        standard.empty() ? "" : fmt::format(" Default: {}.", roff(standard)));
  }
  return text;
}

std::string positionals(const CLI::App& verb) {
  std::string text;
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->get_positional()) continue;
    const std::string name = fmt::format("\\fI{}\\fR", roff(option->get_name(true)));
    text += option->get_required() ? " " + name : " [" + name + "]";
  }
  return text;
}

std::string verb_page(const CLI::App& app, const CLI::App& verb) {
  return title("granuscope " + verb.get_name(), 1) +
         fmt::format(
             ".SH NAME\ngranuscope\\-{0} \\- {1}\n.SH SYNOPSIS\n\\fBgranuscope {0}\\fR [\\fIOPTION\\fR]...{2}\n"
             ".SH DESCRIPTION\n{1}.\n.SH OPTIONS\n{3}.SH EXIT STATUS\n{4}\n"
             ".SH SEE ALSO\n\\fBgranuscope\\fR(1), \\fBgranuscope\\-experiment\\fR(5)\n",
             roff(verb.get_name()), roff(verb.get_description()), positionals(verb), option_list(verb),
             roff(app.get_footer()));
}

std::string program_page(const CLI::App& app) {
  std::string text = title("granuscope", 1) +
                     fmt::format(
                         ".SH NAME\ngranuscope \\- force networks of frictional beads\n.SH SYNOPSIS\n"
                         "\\fBgranuscope\\fR \\fIVERB\\fR [\\fIOPTION\\fR]...\n.SH DESCRIPTION\n{}\n.SH VERBS\n",
                         roff(app.get_description()));
  for (const CLI::App* verb : listed_verbs(app)) {
    text += fmt::format(".TP\n\\fB{}\\fR\n{}. See \\fBgranuscope\\-{}\\fR(1).\n", roff(verb->get_name()),
                        roff(verb->get_description()), roff(verb->get_name()));
  }
  return text + fmt::format(
                    ".SH EXAMPLES\n.nf\ngranuscope example quick >quick.toml\ngranuscope run quick.toml\n.fi\n"
                    ".SH EXIT STATUS\n{}\n.SH SEE ALSO\n\\fBgranuscope\\-experiment\\fR(5)\n",
                    roff(app.get_footer()));
}

/// The cells of a row of a Markdown table, without the code marks.
std::vector<std::string> cells_of(std::string_view row) {
  std::vector<std::string> cells = parts_between(row.substr(2, row.size() - 4), " | ");
  for (std::string& cell : cells) {
    std::erase(cell, '`');
    cell = CLI::detail::find_and_replace(cell, "\\|", "|");
  }
  return cells;
}

/// The keys of an experiment file, from the reference that docs/reference.md shows.
std::string experiment_page() {
  std::string text =
      title("granuscope experiment", 5) +
      ".SH NAME\ngranuscope\\-experiment \\- experiment files of granuscope\n.SH DESCRIPTION\n"
      "An experiment is a TOML file. What it does not say follows from what it says, and an unknown key is an error.\n"
      "\\fBgranuscope example\\fR prints experiments to start from, and \\fBgranuscope run\\fR \\fIFILE\\fR\n"
      "\\fB\\-\\-print\\-config\\fR one with every default resolved.\n.SH KEYS\n";
  std::istringstream rows(describe_experiment_keys());
  for (std::string row; std::getline(rows, row);) {
    if (!row.starts_with("| `")) continue;  // no key, but a heading or the head of a table
    const std::vector<std::string> cells = cells_of(row);
    std::vector<std::string> facts{"default " + cells[1]};
    if (!cells[2].empty()) facts.push_back(cells[2]);
    if (!cells[3].empty()) facts.push_back(cells[3]);
    text += fmt::format(".TP\n\\fB{}\\fR ({})\n{}.\n", roff(cells[0]), roff(fmt::format("{}", fmt::join(facts, "; "))),
                        roff(cells[4]));
  }
  return text + ".SH SEE ALSO\n\\fBgranuscope\\fR(1), \\fBgranuscope\\-run\\fR(1)\n";
}

// Completion ----------------------------------------------------------------------------------------------------------

std::vector<std::string> flags_of(const CLI::App& verb) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : verb.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  return flags;
}

std::string names_of_verbs(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : listed_verbs(app)) names.push_back(verb->get_name());
  return fmt::format("{}", fmt::join(names, " "));
}

std::string bash_completion(const CLI::App& app) {
  std::string text = fmt::format(
      "# bash completion for granuscope\n_granuscope() {{\n  local word=${{COMP_WORDS[COMP_CWORD]}} words=\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n    words=\"{} --help --version\"\n  else\n    case ${{COMP_WORDS[1]}} "
      "in\n",
      names_of_verbs(app));
  for (const CLI::App* verb : listed_verbs(app)) {
    text += fmt::format("      {}) words=\"{}\" ;;\n", verb->get_name(), fmt::join(flags_of(*verb), " "));
  }
  return text +
         "    esac\n    case $word in -*) ;; *) words= ;; esac\n  fi\n"
         "  while IFS= read -r word; do COMPREPLY+=(\"$word\"); done \\\n"
         "    < <(compgen -W \"$words\" -- \"${COMP_WORDS[COMP_CWORD]}\")\n}\n"
         "complete -o default -F _granuscope granuscope\n";
}

/// In single quotes of a shell.
std::string in_quotes(std::string_view text) { return "'" + replaced(text, {{'\'', "'\\''"}}) + "'"; }

std::string fish_completion(const CLI::App& app) {
  std::string text = "# fish completion for granuscope\n";
  for (const CLI::App* verb : listed_verbs(app)) {
    text += fmt::format("complete -c granuscope -n __fish_use_subcommand -a {} -d {}\n", verb->get_name(),
                        in_quotes(verb->get_description()));
    for (const CLI::Option* option : verb->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        text +=
            fmt::format("complete -c granuscope -n '__fish_seen_subcommand_from {}' -l {}{} -d {}\n", verb->get_name(),
                        name, option->get_expected_max() == 0 ? "" : " -r", in_quotes(option->get_description()));
      }
    }
  }
  return text;
}

/// Text inside [...] of an argument of _arguments, and inside single quotes.
std::string zsh_text(std::string_view text) { return replaced(backslashed(text, "[]:"), {{'\'', "'\\''"}}); }

std::string zsh_completion(const CLI::App& app) {
  std::string text = "#compdef granuscope\nif (( CURRENT == 2 )); then\n  _values verb";
  for (const CLI::App* verb : listed_verbs(app)) {
    text += fmt::format(" \\\n    '{}[{}]'", verb->get_name(), zsh_text(verb->get_description()));
  }
  text += "\n  return\nfi\nlocal verb=$words[2]\nshift words\n(( CURRENT-- ))\ncase $verb in\n";
  for (const CLI::App* verb : listed_verbs(app)) {
    text += fmt::format("  {}) _arguments", verb->get_name());
    for (const CLI::Option* option : verb->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        text += fmt::format(" \\\n    '--{}[{}]{}'", name, zsh_text(option->get_description()),
                            option->get_expected_max() == 0 ? "" : ":value:_files");
      }
    }
    text += " \\\n    '*:file:_files' ;;\n";
  }
  return text + "esac\n";
}

}  // namespace

std::map<std::string, std::string> installed_files(const CLI::App& app) {
  std::map<std::string, std::string> files;
  files["man/man1/granuscope.1"] = program_page(app);
  files["man/man5/granuscope-experiment.5"] = experiment_page();
  for (const CLI::App* verb : listed_verbs(app)) {
    files[fmt::format("man/man1/granuscope-{}.1", verb->get_name())] = verb_page(app, *verb);
  }
  files["bash-completion/completions/granuscope"] = bash_completion(app);
  files["zsh/vendor-completions/_granuscope"] = zsh_completion(app);
  files["fish/vendor_completions.d/granuscope.fish"] = fish_completion(app);
  return files;
}

}  // namespace granuscope
