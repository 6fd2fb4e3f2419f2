#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <sstream>

#include "cli/flag_checks.h"
#include "experiment/experiment.h"
#include "experiment/experiment_file.h"
#include "report/page_overlays.h"
#include "report/page_scope.h"
#include "support/plain_text.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {
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

/// The command that somebody may have meant who wrote a file, an example or a word of other programs where a verb
/// belongs; "" if it is none.
std::string command_for(const std::string& word) {
  if (word.ends_with(".toml")) return "run " + word;
  if (word.ends_with(".h5")) return "render " + word;
  if (file_exists(word)) return "run " + word;
  if (std::ranges::count(names_of_examples(), word) > 0) return "example " + word;
  return hint_for(word);
}

}  // namespace

const CLI::App& verb_named(const CLI::App& app, const std::string& name) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_name() == name) return *verb;
    if (!verb->get_group().empty()) verbs.push_back(verb->get_name());
  }
  const auto told = [&]() -> std::string {
    if (const std::string command = command_for(name); !command.empty()) {
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

std::string text_of_example(const std::string& name) {
  return std::string(template_file(fmt::format("{}{}{}", examples_folder, name, extension)));
}

ExitCode print_example(std::string name, VerbContext& context) {
  const std::vector<std::string> names = names_of_examples();
  if (name.empty()) {
    std::string list;
    for (const std::string& known : names)
      list += known + '\t' + parse_experiment(text_of_example(known), known, {}, EmptyFile::allowed, known).name + '\n';
    context.out << aligned(list);
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

std::vector<const CLI::App*> listed_verbs(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

/// Text as roff: a hyphen there is no minus, and a line must not begin as a command does.
std::string roff(std::string_view text) {
  std::string result = replaced(text, {{'-', "\\-"}, {'\\', "\\e"}});
  for (std::size_t at = 0; at < result.size(); at = std::min(result.find('\n', at), result.size() - 1) + 1) {
    if (result[at] == '.' || result[at] == '\'') result.insert(at, "\\&");
  }
  return result;
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

/// Text as one cell of a Markdown table; a bar would end the cell, even inside code.
std::string cell(const std::string& text) { return replaced(text, {{'|', "\\|"}, {'\n', " "}}); }

/// Text in single quotes of a shell, and inside [...] of an argument of zsh's _arguments, which stands in such.
Json spelt(std::string_view text) {
  const auto quoted = [](std::string_view one) { return replaced(one, {{'\'', "'\\''"}}); };
  return {{"roff", roff(text)}, {"quoted", "'" + quoted(text) + "'"}, {"zsh", quoted(backslashed(text, "[]:"))}};
}

/// What the files say of a verb.
Json verb_json(const CLI::App& verb) {
  std::string title = "GRANUSCOPE-" + verb.get_name(), positionals, words;
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  Json options = Json::array(), flags = Json::array();
  for (const CLI::Option* option : verb.get_options()) {
    const std::string name = "\\fI" + roff(option->get_name(true)) + "\\fR";
    if (option->get_positional()) positionals += option->get_required() ? " " + name : " [" + name + "]";
    options.push_back(
        {{"head", option_head(*option)},
         {"about", roff(option->get_description())},
         {"standard", roff(option->get_default_str())},
         {"names", cell(option->nonpositional() ? option->get_name(false, true) : option->get_name(true))},
         {"type", option->get_expected_max() == 0 ? "" : cell(option->get_type_name())},
         {"default", cell(option->get_default_str())},
         {"meaning", cell(option->get_description())}});
    for (const std::string& flag : option->get_lnames()) {
      words += (words.empty() ? "--" : " --") + flag;
      flags.push_back({{"verb", verb.get_name()},
                       {"name", flag},
                       {"about", spelt(option->get_description())},
                       {"takes_value", option->get_expected_max() != 0}});
    }
  }
  return {{"name", verb.get_name()},
          {"title", roff(title)},
          {"about", spelt(verb.get_description())},
          {"plain", verb.get_description()},
          {"positionals", positionals},
          {"words", words},
          {"options", options},
          {"flags", flags}};
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
Json keys_json() {
  Json keys = Json::array();
  std::istringstream rows(describe_experiment_keys());
  for (std::string row; std::getline(rows, row);) {
    if (!row.starts_with("| `")) continue;  // no key, but a heading or the head of a table
    const std::vector<std::string> cells = cells_of(row);
    std::string facts = "default " + cells[1];
    for (const std::string& fact : {cells[2], cells[3]}) facts += fact.empty() ? "" : "; " + fact;
    keys.push_back({{"name", roff(cells[0])}, {"facts", roff(facts)}, {"meaning", roff(cells[4])}});
  }
  return keys;
}

Json verbs_json(const CLI::App& app) {
  Json verbs = Json::array();
  for (const CLI::App* verb : listed_verbs(app)) verbs.push_back(verb_json(*verb));
  return verbs;
}

std::string filled(const std::string& name, const Json& json) {
  return fill_template_file("install/" + name + ".mustache", PageScope(Json(), json, Markup::plain));
}

/// What an installation has beside the program, made from the very objects that read the command line: manual pages and
/// completion files for bash, zsh and fish. Path below share/ -> content.
std::map<std::string, std::string> installed_files(const CLI::App& app) {
  const std::string program = provenance_line(collect_provenance());
  const Json all = {{"version", roff(program.substr(0, program.find(',')))}, {"exit_codes", roff(app.get_footer())}};
  std::map<std::string, std::string> files;
  const auto fill = [&](const std::string& file, const std::string& name, Json json) {
    json.update(all);
    files[file] = filled(name, json);
  };
  const Json verbs = verbs_json(app);
  for (const Json& verb : verbs)
    fill(fmt::format("man/man1/granuscope-{}.1", verb.at("name").get<std::string>()), "verb.1", verb);
  fill("man/man1/granuscope.1", "granuscope.1", {{"verbs", verbs}, {"about", roff(app.get_description())}});
  fill("man/man5/granuscope-experiment.5", "experiment.5", {{"keys", keys_json()}});
  fill("bash-completion/completions/granuscope", "bash", {{"verbs", verbs}});
  fill("zsh/vendor-completions/_granuscope", "zsh", {{"verbs", verbs}});
  fill("fish/vendor_completions.d/granuscope.fish", "fish", {{"verbs", verbs}});
  return files;
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
    context.out << (*verbs ? filled("verbs.md", {{"verbs", verbs_json(app)}}) : describe_experiment_keys());
    return ExitCode::done;
  };
}

}  // namespace granuscope
