#include "experiment/experiment_file.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "experiment/experiment_check.h"
#include "experiment/experiment_keys.h"
#include "experiment/nearest_name.h"
#include "support/atomic_file.h"
#include "support/error.h"

namespace granuscope {
namespace {

constexpr std::uintmax_t most_bytes = 1'000'000;  // a hundred times the largest sensible experiment file

std::string location(const std::string& file, const toml::source_position& position) {
  return fmt::format("{}:{}:{}", file, position.line, position.column);
}

std::optional<double> to_number(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return number->get();
  if (const auto* number = node.as_integer()) return static_cast<double>(number->get());  // 0 for 0.0
  return {};
}

std::optional<std::vector<std::int64_t>> to_whole_numbers(const toml::node& node) {
  const auto* array = node.as_array();
  if (array == nullptr) return {};
  std::vector<std::int64_t> numbers;
  for (const toml::node& element : *array) {
    if (!element.is_integer()) return {};
    numbers.push_back(element.as_integer()->get());
  }
  return numbers;
}

std::optional<std::vector<double>> to_numbers(const toml::node& node) {
  const auto* array = node.as_array();
  if (array == nullptr) return {};
  std::vector<double> numbers;
  for (const toml::node& element : *array) {
    const auto number = to_number(element);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<NumberPairs> to_pairs(const toml::node& node) {
  const auto* array = node.as_array();
  if (array == nullptr) return {};
  NumberPairs pairs;
  for (const toml::node& element : *array) {
    const auto pair = to_numbers(element);
    if (!pair || pair->size() != 2) return {};
    pairs.push_back({(*pair)[0], (*pair)[1]});
  }
  return pairs;
}

/// Turns a node into the alternative it is called with; nothing if the node has another type.
struct NodeReader {
  const toml::node& node;

  template <class Plain, class Node>
  static std::optional<KeyValue> from(const Node* found) {
    return found == nullptr ? std::nullopt : std::optional<KeyValue>(Plain(found->get()));
  }
  template <class List>
  static std::optional<KeyValue> from(const std::optional<List>& found) {
    return found ? std::optional<KeyValue>(*found) : std::nullopt;
  }

  std::optional<KeyValue> operator()(bool) const { return from<bool>(node.as_boolean()); }
  std::optional<KeyValue> operator()(std::int64_t) const { return from<std::int64_t>(node.as_integer()); }
  std::optional<KeyValue> operator()(double) const { return from(to_number(node)); }
  std::optional<KeyValue> operator()(const std::string&) const { return from<std::string>(node.as_string()); }
  std::optional<KeyValue> operator()(const std::vector<std::int64_t>&) const { return from(to_whole_numbers(node)); }
  std::optional<KeyValue> operator()(const std::vector<double>&) const { return from(to_numbers(node)); }
  std::optional<KeyValue> operator()(const NumberPairs&) const { return from(to_pairs(node)); }
};

/// The node as the same alternative that `like` holds.
std::optional<KeyValue> to_value(const toml::node& node, const KeyValue& like) {
  return std::visit(NodeReader{node}, like);
}

/// Reads one parsed document into an experiment and remembers where each key stood.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {
    tables_.insert("gate");
    for (const ExperimentKey& key : experiment_keys()) {
      keys_[key.path()] = &key;
      for (auto dot = key.table.find('.'); dot != std::string::npos; dot = key.table.find('.', dot + 1)) {
        tables_.insert(key.table.substr(0, dot));
      }
      tables_.insert(key.table);
    }
    tables_.insert(expected_verdicts_table);
  }

  Experiment read(const toml::table& document) {
    read_table(document, "");
    for (double& mu : experiment_.mu) mu += 0.0;  // -0.0 becomes 0, whose sign no file name should show
    for (std::vector<double>* list : {&experiment_.mu, &experiment_.redrawn_beads.mu, &experiment_.counted_work.mu,
                                      &experiment_.small_friction.mu}) {
      std::sort(list->begin(), list->end());
    }
    for (std::vector<int>* list : {&experiment_.figures.profile_layers, &experiment_.counted_work.sizes}) {
      std::sort(list->begin(), list->end());
    }
    if (const auto problem = find_problem(experiment_)) {
      const auto written = positions_.find(problem->key);
      throw InputError(
          written != positions_.end()
              ? fmt::format("{}: {}: {}", location(file_, written->second), problem->key, problem->message)
              : fmt::format("{}: {} (not in the file, default): {}", file_, problem->key, problem->message));
    }
    return experiment_;
  }

 private:
  void read_table(const toml::table& table, const std::string& path) {
    for (const auto& [name, node] : table) {
      const std::string child = path.empty() ? std::string(name.str()) : fmt::format("{}.{}", path, name.str());
      const toml::source_position position = name.source().begin;
      if (path == expected_verdicts_table) {
        read_verdict(std::string(name.str()), node, position);
      } else if (tables_.count(child) != 0) {
        if (!node.is_table()) {
          throw InputError(fmt::format("{}: {} must be a table but is {}; write [{}] on a line of its own",
                                       location(file_, position), child, describe(node), child));
        }
        read_table(*node.as_table(), child);
      } else if (const auto known = keys_.find(child); known != keys_.end()) {
        read_key(*known->second, node, position);
      } else {
        refuse(path, std::string(name.str()), position);
      }
    }
  }

  void read_key(const ExperimentKey& key, const toml::node& node, const toml::source_position& position) {
    const KeyValue like = key.get(experiment_);
    const auto value = to_value(node, like);
    if (!value) {
      throw InputError(fmt::format("{}: {} must be {} but is {}; {}", location(file_, position), key.path(),
                                   kind_of(like), describe(node), key.meaning));
    }
    try {
      key.set(experiment_, *value);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}: {}", location(file_, position), key.path(), error.what()));
    }
    positions_[key.path()] = position;
  }

  void read_verdict(const std::string& claim, const toml::node& node, const toml::source_position& position) {
    const auto* verdict = node.as_string();
    if (verdict == nullptr) {
      throw InputError(fmt::format("{}: {}.{} must be a string but is {}; {}", location(file_, position),
                                   expected_verdicts_table, claim, describe(node), expected_verdicts_meaning));
    }
    experiment_.expected_verdicts[claim] = verdict->get();
    positions_[fmt::format("{}.{}", expected_verdicts_table, claim)] = position;
  }

  [[noreturn]] void refuse(const std::string& table, const std::string& name, const toml::source_position& position) {
    const std::string path = table.empty() ? name : table + "." + name;
    std::vector<std::string> known(tables_.begin(), tables_.end());
    std::vector<std::string> siblings;
    std::optional<std::string> meant;
    for (const auto& [key_path, key] : keys_) {
      known.push_back(key_path);
      if (key->table == table) siblings.push_back(key->name);
      if (key->name == name && key->name != "draw") meant = key_path;  // the right key in the wrong table
    }
    if (const auto sibling = nearest_name(name, siblings)) meant = table + "." + *sibling;
    if (!meant) meant = nearest_name(path, known);
    std::string advice = meant ? fmt::format("did you mean {}?", *meant) : "";
    if (!meant && !siblings.empty()) advice = fmt::format("[{}] knows {}", table, fmt::join(siblings, ", "));
    if (!meant && siblings.empty()) advice = fmt::format("the tables are {}", fmt::join(tables_, ", "));
    throw InputError(fmt::format("{}: unknown key {}: a mistyped key would silently keep its default; {}",
                                 location(file_, position), path, advice));
  }

  static std::string describe(const toml::node& node) {
    if (node.is_table()) return "a table";
    if (node.is_array()) return "a list that holds something else";
    if (node.is_string()) return "a string";
    if (node.is_boolean()) return "true or false";
    if (node.is_integer()) return "a whole number";
    if (node.is_floating_point()) return "a number with a fraction";
    return "a date or time";
  }

  std::string file_;
  Experiment experiment_;
  std::map<std::string, const ExperimentKey*> keys_;
  std::set<std::string> tables_;
  std::map<std::string, toml::source_position> positions_;
};

}  // namespace

Experiment parse_experiment(std::string_view text, const std::string& file) {
  if (text.size() > most_bytes) {
    throw InputError(
        fmt::format("{}: {} bytes are too many for an experiment file (the limit is {}); is this the right "
                    "file?",
                    file, text.size(), most_bytes));
  }
  try {
    return Reader(file).read(toml::parse(text, file));
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}: not valid TOML: {}; correct the file", location(file, error.source().begin),
                                 error.description()));
  }
}

Experiment read_experiment(const std::filesystem::path& file) {
  std::error_code code;
  const auto status = std::filesystem::status(file, code);
  if (!std::filesystem::exists(status)) {
    throw InputError(
        fmt::format("{}: there is no such file; give the path of an experiment file (TOML)", file.string()));
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw InputError(
        fmt::format("{}: {}, but an experiment is a file (TOML)", file.string(),
                    std::filesystem::is_directory(status) ? "this is a folder" : "this is not a plain file"));
  }
  const auto size = std::filesystem::file_size(file, code);
  if (!code && size > most_bytes) {
    throw InputError(
        fmt::format("{}: {} bytes are too many for an experiment file (the limit is {}); is this the right "
                    "file?",
                    file.string(), size, most_bytes));
  }
  return parse_experiment(read_file(file), file.string());
}

}  // namespace granuscope
