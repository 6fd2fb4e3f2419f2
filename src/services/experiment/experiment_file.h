#pragma once
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/experiment.h"

namespace granuscope {

/// What to do about a file without any key: the defaults are an experiment, but one that nobody may have meant.
enum class EmptyFile { refused, allowed };

/// Reads and checks an experiment file (TOML), with `overrides` KEY=VALUE in the place of what it says. Throws
/// InputError, naming file, line, column and key, for a file that cannot be read, has no key or is not TOML, for an
/// unknown key (with the nearest known one), for a value of the wrong type or out of its range, and for values that
/// contradict each other (find_problem).
Experiment read_experiment(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// The same from a stream, which messages call `name`.
Experiment read_experiment(std::istream& in, const std::vector<std::string>& overrides,
                           const std::string& name = "standard input");

/// The same from text; `file` is only what messages call it, `title` the name of an experiment that has none.
Experiment parse_experiment(std::string_view text, const std::string& file,
                            const std::vector<std::string>& overrides = {}, EmptyFile empty = EmptyFile::allowed,
                            const std::string& title = {});

/// What is written in numbers elsewhere and not here, and what to write instead: a sign for minus, or a decimal comma
/// in what is no list; "" if nothing is found. The text may begin as KEY=.
std::string odd_sign_in(std::string_view text);

/// The experiment as TOML with every key written out and commented. It reads back to an equal experiment, and the same
/// experiment gives the same bytes.
std::string print_experiment(const Experiment& experiment);

/// The lines of it that differ from those of the default experiment, without comments.
std::string print_changes(const Experiment& experiment);

/// The reference of all keys as a Markdown table (key, default, unit, meaning).
std::string describe_experiment_keys();

}  // namespace granuscope
