#include "cli/command_line.h"

#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <map>
#include <new>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "cli/verbs.h"
#include "experiment/experiment.h"
#include "experiment/experiment_file.h"
#include "experiment/experiment_keys.h"
#include "support/error.h"
#include "support/key.h"
#include "support/plain_text.h"
#include "support/progress.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {

namespace {

/// Longer than any message that means something.
constexpr std::size_t most_message_bytes = 4000;

}  // namespace

std::string hint_for(const std::string& word) {
  const std::string text = "\n" + std::string(template_file("hints.txt")), begins = "\n" + word + " = ";
  const std::size_t at = text.find(begins), from = at + begins.size();
  return at == std::string::npos ? "" : text.substr(from, text.find('\n', from) - from);
}

void VerbContext::wrote(const std::string& file, const std::string& how) const {
  err << "wrote " << single_line(file + how, most_message_bytes) << '\n';
}

StandardOutput::int_type StandardOutput::overflow(int_type letter) {
  if (letter == traits_type::eof()) return 0;
  const char one = traits_type::to_char_type(letter);
  return xsputn(&one, 1) == 1 ? letter : traits_type::eof();
}

std::streamsize StandardOutput::xsputn(const char* text, std::streamsize size) {
  constexpr std::size_t enough = std::size_t{1} << 16;
  text_.append(text, static_cast<std::size_t>(size));
  return text_.size() < enough || put_out() ? size : 0;
}

bool StandardOutput::put_out() {
  std::string_view left = text_;
  bool good = true;
  while (good && !left.empty()) {
    const ssize_t written = ::write(descriptor_, left.data(), left.size());
    if (written >= 0) {
      left.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EAGAIN) {
      pollfd output = {descriptor_, POLLOUT, 0};
      (void)::poll(&output, 1, -1);
    } else {
      good = errno == EINTR;
    }
  }
  text_.clear();
  return good;
}

namespace {

constexpr const char* exit_codes =
    "Exit status: 0 all was made; 1 a claim came out otherwise than expected (with --gate), or a night alarms; 2 the\n"
    "command line, the experiment or a file cannot be used; 3 the machine lacks a program, OpenGL, space or "
    "permission\n"
    "to write; 4 interrupted: the same command goes on; 5 another run is at work in the folder. Lengths are in bead\n"
    "diameters, forces in loads of one top bead.";

/// What a flag that the verb does not have was probably meant to be; "" if nobody knows. `value`: what it was given.
std::string meant_by_flag(const CLI::App& verb, const std::string& flag, const std::string& value) {
  const auto has = [&verb](const std::string& name) { return verb.get_option_no_throw(name) != nullptr; };
  const std::string here = hint_for("--" + flag);
  if (here.starts_with('(') && has("--set")) return " " + here;
  if (here.starts_with('-') && has(here)) return fmt::format(" (did you mean {}?)", here);
  const bool writes_file = verb.get_name() == "new";
  if (has("--set") || writes_file) {
    Experiment any;
    std::string name = flag;
    std::ranges::replace(name, '-', '_');
    if (const std::string key = nearest_to_top(keys_of(any), name); !key.empty()) {
      return fmt::format(" ({}--set {})", writes_file ? "write it into the file, or: granuscope run FILE " : "write ",
                         shell_word(fmt::format("{}={}", key, value)));
    }
  }
  std::vector<std::string> known;
  for (const CLI::Option* option : verb.get_options())
    known.insert(known.end(), option->get_lnames().begin(), option->get_lnames().end());
  const auto meant = nearest_name(flag, known);
  return meant ? fmt::format(" (did you mean --{}?)", *meant) : "";
}

/// The flags on the command line that the verb does not have, each with what was probably meant; "" if there are none.
/// CLI11 lists words without saying which of them is wrong.
std::string find_unknown_flags(const CLI::App& verb, int argc, const char* const* argv) {
  std::vector<std::string> unknown;
  for (int i = 2; i < argc; ++i) {
    const std::string word(argv[i]);
    if (word == "--") break;
    if (word.size() < 2 || word[0] != '-') continue;
    // A letter, perhaps with its value; a number is none.
    const bool letter = word[1] != '-';
    if (letter && std::isalpha(static_cast<unsigned char>(word[1])) == 0) continue;
    const std::string dashed = letter ? word.substr(0, 2) : word.substr(0, word.find('='));
    if (verb.get_option_no_throw(dashed) != nullptr) continue;
    const bool next = word == dashed && i + 1 < argc && argv[i + 1][0] != '-';
    const std::string value = next             ? argv[i + 1]
                              : word == dashed ? "VALUE"
                                               : word.substr(dashed.size() + (letter ? 0 : 1));
    unknown.push_back(dashed + meant_by_flag(verb, dashed.substr(letter ? 1 : 2), value));
  }
  if (unknown.empty()) return "";
  return fmt::format("{} has no flag{} {}", verb.get_name(), unknown.size() > 1 ? "s" : "", fmt::join(unknown, ", "));
}

/// A word that begins with a dash where a verb is expected: a slip in a flag of the program, or a verb's flag.
std::string name_unknown_flag(const CLI::App& app, const std::string& word) {
  const std::string flag = word.substr(0, word.find('=')).substr(std::min(word.find_first_not_of('-'), word.size()));
  const auto lower = [](const std::string& text) { return std::tolower(static_cast<unsigned char>(text[0])); };
  for (const CLI::Option* option : app.get_options()) {  // each has a letter and a name
    const std::string& letter = option->get_snames().front();
    const bool other_case = flag.size() == 1 && lower(flag) == lower(letter);
    if (!other_case && !nearest_name(flag, option->get_lnames())) continue;
    return fmt::format("there is no flag {}; did you mean -{} (--{})?", word, letter, option->get_lnames().front());
  }
  std::map<std::string, std::vector<std::string>> verbs;  // by flag
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); })) {
    for (const CLI::Option* option : verb->get_options()) {
      for (const std::string& name : option->get_lnames()) verbs[name].push_back(verb->get_name());
    }
  }
  std::vector<std::string> names;
  names.reserve(verbs.size());
  for (const auto& [name, of] : verbs) names.push_back(name);
  const auto meant = nearest_name(flag, names);
  if (!meant) return fmt::format("there is no flag {}; but for --help and --version flags stand behind a verb", word);
  if (*meant == flag) return fmt::format("{} stands behind a verb: {}", word, fmt::join(verbs[flag], ", "));
  return fmt::format("there is no flag {}; did you mean --{} of {}?", word, *meant, fmt::join(verbs[*meant], ", "));
}

/// Where a word belongs that the verb does not expect: behind a flag for a file, or for names. "" if nobody knows.
std::string place_of(const CLI::App& verb, const std::string& word) {
  const std::string suffix = suffix_of(word);
  const bool file = suffix.size() > 1 && std::isalpha(static_cast<unsigned char>(suffix[1])) != 0;
  if (file && verb.get_option_no_throw("-o") != nullptr) return "; write -o " + shell_word(word);
  return verb.get_name() == "numbers" ? "; write --only " + shell_word(word) : "";
}

/// What is wrong with the command line, and where to look.
std::string explain(const CLI::ParseError& error, const CLI::App& app, int argc, const char* const* argv) {
  const std::vector<const CLI::App*> chosen = app.get_subcommands([](const CLI::App* verb) { return verb->parsed(); });
  std::string what = error.what();
  if (!chosen.empty()) {
    if (const std::string unknown = find_unknown_flags(*chosen.front(), argc, argv); !unknown.empty()) what = unknown;
  }
  if (chosen.empty() && what == "A subcommand is required") what = name_unknown_flag(app, argv[1]);
  if (what.starts_with("The following argument")) {  // was not expected; of several CLI11 lists the last one first
    const std::vector<std::string> words = (chosen.empty() ? &app : chosen.front())->remaining(true);
    if (!words.empty()) {
      what = fmt::format("\"{}\" is one word more than is expected here{}", words.front(),
                         chosen.empty() ? "" : place_of(*chosen.front(), words.front()));
    }
  }
  if (what == "CONFIG is required") {
    return "an experiment file is needed, since it says what to run; name one, or take a built-in one: granuscope "
           "example lists them";
  }
  constexpr std::string_view value = "Value ", out_of_range = " not in range ";  // also of what is no number
  const std::size_t begins = what.find(value), ends = what.find(out_of_range);
  if (begins != std::string::npos && ends != std::string::npos) {
    what.replace(ends, out_of_range.size(), " is no number from ");
    what.erase(begins, value.size());
  }
  constexpr std::string_view unconverted = "Could not convert: ";
  const bool of_value = what.starts_with(unconverted);
  if (of_value) what = what.substr(unconverted.size()) + " is not a value that this flag can take";
  if (const std::string odd = of_value ? odd_sign_in(what) : ""; !odd.empty()) what += "; " + odd;
  return fmt::format("{}; granuscope{} --help lists what can be written here", what,
                     chosen.empty() ? "" : " " + chosen.front()->get_name());
}

/// Makes an option read 1e3 and 64.0, which are whole numbers, too, and say what is wrong with a count that is none.
void read_whole_numbers(CLI::Option& option) {
  const std::string type = option.get_type_name();
  if (type.find("INT") == std::string::npos) return;
  const auto in_digits = [count = type.starts_with("UINT")](std::string& text) -> std::string {
    const std::string sign = !count && text.starts_with('-') ? "-" : "";
    std::uint64_t number = 0;
    try {
      key_fields::from_text(number, text.substr(sign.size()));
      text = sign + std::to_string(number);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  option.transform(CLI::Validator(in_digits, "", ""));
}

/// No list of nothing, after which CLI11 would take the next flag for its value, and no signs of other places.
void require_lists(int argc, const char* const* argv) {
  for (int i = 2; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (!word.empty() && word.find_first_not_of(',') == std::string_view::npos) {
      throw InputError("\"{}\" behind {} is a list of nothing; give it values or leave it out", word, argv[i - 1]);
    }
    const std::string_view value = word.substr(word.find('=') + 1);
    const bool numbers = value.find_first_not_of("0123456789.,eE+-\u2212") == std::string_view::npos;
    if (numbers && value.find("\u2212") != std::string_view::npos) throw InputError("{}: {}", word, odd_sign_in(value));
  }
}

/// A shell variable that was never set leaves an empty word, which would quietly stand for the flag's default.
void require_values(const CLI::App& verb) {
  for (const CLI::Option* option : verb.get_options()) {
    for (const std::string& value : option->results()) {
      if (value.empty()) {
        throw InputError("{} is empty, which names nothing; give it a value or leave it out", option->get_name());
      }
    }
  }
}

/// Whether standard output is a pipe whose reader has gone.
bool reader_has_gone() {
  pollfd output = {STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

void require_written(std::ostream& out) {
  out.flush();
  if (out || reader_has_gone()) return;  // who leaves early, as head does, has got what he wanted
  throw EnvironmentError("standard output cannot be written, so that the result is lost; free space or check the pipe");
}

/// Whether the system refused a thread.
bool lacks_threads(const std::exception& error) {
  const auto* system = dynamic_cast<const std::system_error*>(&error);
  return system != nullptr && system->code() == std::errc::resource_unavailable_try_again;
}

ExitCode parse_and_act(int argc, const char* const* argv, std::ostream& out, std::ostream& err, Crew* crew) {
  CLI::App app{
      "Random force networks of frictional beads: how a point load spreads through them, in numbers, pictures and one "
      "report.",
      "granuscope"};
  app.footer(exit_codes);
  app.require_subcommand(1);
  app.set_version_flag("-V,--version", [] { return provenance_line(collect_provenance()); });
  VerbContext context{out, err, {}, crew};
  add_new_verb(app, context);
  add_run_verb(app, context);
  add_merge_verb(app, context);
  add_sample_verb(app, context);
  add_render_verb(app, context);
  add_export_verb(app, context);
  add_contacts_verb(app, context);
  add_audit_verb(app, context);
  add_compare_verb(app, context);
  add_nightly_verb(app, context);
  add_history_verb(app, context);
  add_bench_verb(app, context);
  add_doctor_verb(app, context);
  add_figure_verb(app, context);
  add_numbers_verb(app, context);
  add_pack_verb(app, context);
  add_article_verb(app, context);
  add_example_verb(app, context);
  add_explain_verb(app, context);
  add_help_verb(app, context);
  add_reference_verb(app, context);
  app.get_formatter()->label("SUBCOMMAND", "VERB");
  for (CLI::App* verb : app.get_subcommands([](CLI::App* added) { return !added->get_group().empty(); })) {
    verb->group("Verbs");
    for (CLI::Option* option : verb->get_options()) read_whole_numbers(*option);
  }

  if (argc < 2) {
    err << app.help();
    return ExitCode::bad_input;
  }
  if (argv[1][0] != '-') (void)verb_named(app, argv[1]);  // CLI11 would only say that a verb is missing
  try {
    require_lists(argc, argv);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      app.exit(error, out, err);
      require_written(out);
      return ExitCode::done;
    }
    throw InputError(explain(error, app, argc, argv));
  }
  for (const CLI::App* verb : app.get_subcommands()) require_values(*verb);
  install_interruption_handlers();
  const ExitCode code = context.actions.at(app.get_subcommands().front())();
  require_written(out);
  return code;
}

}  // namespace

int run_command_line(int argc, const char* const* argv, std::ostream& out, std::ostream& err, Crew* crew) {
  // The one place where errors become an exit status.
  ExitCode code = ExitCode::environment;
  std::string message;
  std::vector<std::string> messages;  // where there are several
  try {
    return static_cast<int>(parse_and_act(argc, argv, out, err, crew));
  } catch (const InputError& error) {
    code = error.exit_code();
    messages = error.messages();
  } catch (const Error& error) {
    code = error.exit_code();
    message = error.what();
  } catch (const std::bad_alloc&) {
    message = "there is not enough memory for this; make the pile smaller or use fewer --threads";
  } catch (const std::length_error&) {
    message = "this is larger than any memory; make the pile smaller";
  } catch (const std::logic_error& error) {
    const bool own = templates_folder().empty();
    if (!own) code = ExitCode::bad_input;
    message = own ? fmt::format("a fault of the program, not of the input: {}; please report it with the command line",
                                error.what())
                  : fmt::format("a file in {} cannot stand in for a template: {}; compare it with that of templates/",
                                templates_folder().string(), error.what());
  } catch (const std::filesystem::filesystem_error& error) {  // where nobody had more to say
    message = fmt::format("{}: {} Check TMPDIR, too, where it is set.", error.path1().string(),
                          system_reason(error.code().value()));
  } catch (const std::exception& error) {
    message = lacks_threads(error)
                  ? fmt::format(
                        "no thread can be started ({}), and without one nothing is drawn; raise the limit on processes "
                        "(ulimit -u, or that of the container)",
                        error.what())
                  : fmt::format("a fault of the program, not of the input: {}; please report it with the command line",
                                error.what());
  }
  // Names of files and what other programs said may hold anything.
  if (messages.empty()) messages.push_back(message);
  for (const std::string& one : messages) err << "granuscope: " << single_line(one, most_message_bytes) << '\n';
  err.flush();
  return static_cast<int>(code);
}

}  // namespace granuscope
