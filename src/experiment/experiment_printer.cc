#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "experiment/experiment_file.h"
#include "experiment/experiment_keys.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// A TOML basic string on one line.
std::string quote(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(byte));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

/// The shortest TOML float that reads back to the same double.
std::string print_number(double number) {
  const std::string text = exact(number);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

template <class List, class Print>
std::string print_list(const List& list, Print print) {
  std::string text;
  for (const auto& element : list) text += (text.empty() ? "" : ", ") + print(element);
  return "[" + text + "]";
}

std::string print_value(const KeyValue& value) {
  struct Visitor {
    std::string operator()(bool on) const { return on ? "true" : "false"; }
    std::string operator()(std::int64_t number) const { return std::to_string(number); }
    std::string operator()(double number) const { return print_number(number); }
    std::string operator()(const std::string& text) const { return quote(text); }
    std::string operator()(const std::vector<std::int64_t>& numbers) const {
      return print_list(numbers, [](std::int64_t number) { return std::to_string(number); });
    }
    std::string operator()(const std::vector<double>& numbers) const { return print_list(numbers, print_number); }
    std::string operator()(const NumberPairs& pairs) const {
      return print_list(pairs, [](const std::array<double, 2>& pair) { return print_list(pair, print_number); });
    }
  };
  return std::visit(Visitor{}, value);
}

bool is_bare_key(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::string escape_table_cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

}  // namespace

std::string print_experiment(const Experiment& experiment) {
  std::string text;
  std::string table;
  Experiment copy = experiment;  // keys could set what they print
  std::vector<Key> keys = keys_of(copy);
  for (const auto& [name, picture] : experiment.pictures) {
    for (Key& key : picture_keys(copy, name)) keys.push_back(std::move(key));
  }
  for (const Key& key : keys) {
    if (key.table != table) {
      text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", key.table);
      table = key.table;
    }
    const std::string unit = key.unit.empty() ? "" : fmt::format(" [{}]", key.unit);
    text += fmt::format("# {}{}\n{} = {}\n", key.meaning, unit, key.name, print_value(key.get()));
  }
  text += fmt::format("\n[{}]\n# {}\n", expected_verdicts_table, expected_verdicts_meaning);
  for (const auto& [claim, verdict] : experiment.expected_verdicts) {
    text += fmt::format("{} = {}\n", is_bare_key(claim) ? claim : quote(claim), quote(verdict));
  }
  return text;
}

std::string print_changes(const Experiment& experiment) {
  const auto tables_of = [](const std::string& text) {
    std::map<std::string, std::set<std::string>> tables;
    std::istringstream lines(text);
    std::string table;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with('[')) table = line;
      tables[table].insert(line);
    }
    return tables;
  };
  const auto defaults = tables_of(print_experiment(Experiment{}));
  std::istringstream lines(print_experiment(experiment));
  std::string text, table, pending;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) {
      table = line;
      pending = (text.empty() ? "" : "\n") + line + "\n";
      continue;
    }
    const auto same = defaults.find(table);
    if (line.empty() || line.starts_with('#') || (same != defaults.end() && same->second.contains(line))) continue;
    text += std::exchange(pending, "") + line + "\n";
  }
  return text;
}

std::string describe_experiment_keys() {
  Experiment defaults;
  defaults.pictures.try_emplace("<name>");
  std::string text = "| key | default | unit | range | meaning |\n|---|---|---|---|---|\n";
  const auto add_rows = [&text](const std::vector<Key>& keys) {
    for (const Key& key : keys) {
      const KeyValue value = key.get();
      text += fmt::format("| `{}` | `{}` | {} | {} | {} |\n", key.path(), print_value(value), key.unit,
                          describe(key.range, value), escape_table_cell(key.meaning));
    }
  };
  add_rows(keys_of(defaults));
  add_rows(picture_keys(defaults, "<name>"));
  text += fmt::format("| `{}.<claim>` | none | | | {} |\n", expected_verdicts_table, expected_verdicts_meaning);
  return text;
}

}  // namespace granuscope
