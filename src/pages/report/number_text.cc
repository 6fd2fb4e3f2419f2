#include "report/number_text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>
#include <stdexcept>

#include "report/clean_json.h"
#include "report/page_overlays.h"
#include "report/page_scope.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
constexpr const char* unknown = "n/a";

/// Four significant digits, without the zeros that only fill them up: 0.3 is a setting, not 0.3000, and 10⁻⁹ no
/// 1.000 × 10⁻⁹.
std::string plain_number(double value) {
  std::string text = significant(value, 4);
  const std::size_t times = text.find(" × ");
  std::string digits = text.substr(0, times);
  if (digits.find('.') == std::string::npos) return text;
  while (digits.back() == '0') digits.pop_back();
  if (digits.back() == '.') digits.pop_back();
  return times == std::string::npos ? digits : digits + text.substr(times);
}

std::string fixed_number(double number, int decimals) {
  std::string text = fmt::format("{:.{}f}", std::abs(number), decimals);
  if (number < 0 && text.find_first_not_of("0.") != std::string::npos) text.insert(0, "−");
  return text;
}

/// 2, of "fixed 2".
int digits_of(std::string_view format) {
  const std::string digits(format.substr(format.find(' ') + 1));
  if (digits.empty() || digits.size() > 2 || digits.find_first_not_of("0123456789") != std::string::npos) {
    throw std::logic_error(fmt::format("\"{}\" does not say how many digits", format));
  }
  return std::stoi(digits);
}

/// An exponent whose points keep to no power law lies between those of parts of its window: its error says nothing.
bool is_no_power(const Json& estimate) { return estimate.contains("power_law") && estimate["power_law"] == false; }

}  // namespace

std::string format_number(const Json& value, std::string_view format) {
  if (value.is_null()) return unknown;
  if (value.is_string()) return value.get<std::string>();
  const bool estimate = value.is_object() && value.contains("value") && value.contains("stderr");
  if (!value.is_number() && !estimate) throw std::logic_error("neither a number nor a text: " + value.dump());
  if (estimate) {
    if (value["value"].is_null() || value["stderr"].is_null()) return unknown;
    const auto number = value["value"].get<double>(), error = value["stderr"].get<double>();
    if (is_no_power(value)) return significant(number, 3);
    if (format == "plain") return plain_value_with_error(number, error);
    if (format.empty()) return value_with_error(number, error);
  } else if (format.starts_with("fixed ")) {
    return fixed_number(value.get<double>(), digits_of(format));
  } else if (format.starts_with("significant ")) {
    return significant(value.get<double>(), digits_of(format));
  } else if (format.empty() || format == "plain") {
    if (value.is_number_unsigned()) return std::to_string(value.get<std::uint64_t>());
    if (value.is_number_integer()) return fmt::format("{}", value.get<std::int64_t>());
    return plain_number(value.get<double>());
  }
  throw std::logic_error(fmt::format("{} is not written in the format \"{}\"", value.dump(), format));
}

std::string plain_value_with_error(double value, double standard_error) {
  constexpr int digits_if_exact = 6, smallest_exponent = -12;
  constexpr double rounding = 1e-14;  // of a mean of numbers that are all the same
  if (standard_error < rounding * std::abs(value)) standard_error = 0;
  return value_with_error(value, standard_error, digits_if_exact, smallest_exponent);
}

namespace {

struct NamedNumber {
  std::string name;
  Json value, standard_error;  ///< the latter null where there is none
  std::string text;
  bool no_power = false;  ///< its points keep to no power law
  std::string reason;     ///< why it is unknown; then there is no value
};

class NumberList {
 public:
  /// `scanned`: what tells results apart.
  explicit NumberList(std::string scanned) : scanned_(std::move(scanned)) {}

  void add(const std::string& name, const Json& json) {
    if (json.is_object() && json.contains("value") && json.contains("stderr")) {
      if (json["value"].is_number()) return take(name, json["value"], json["stderr"], is_no_power(json));
      numbers_.push_back(
          {unique(name), nullptr, nullptr, unknown, false, json.value("reason", "nothing was measured")});
    } else if (json.is_object()) {
      for (const auto& [key, inside] : json.items()) {
        if (key == "measured" && json.contains("stderr") && inside.is_number()) {
          take(below(name, key), inside, json["stderr"], is_no_power(json));
        } else if (key != "stderr" || !json.contains("measured")) {
          add(below(name, key), inside);
        }
      }
    } else if (json.is_array()) {
      for (std::size_t i = 0; i < json.size(); ++i) add(below(name, name_of(json[i], i)), json[i]);
    } else if (json.is_number()) {
      take(name, json, nullptr);
    }
  }

  const std::vector<NamedNumber>& numbers() const { return numbers_; }

 private:
  /// Results and exponents are what a text is about: their names are short.
  static std::string below(const std::string& name, const std::string& key) {
    return name.empty() || name == "results" || name == "scaling" ? key : name + "/" + key;
  }

  std::string name_of(const Json& element, std::size_t index) const {
    if (element.is_object()) {
      for (const std::string& key : {scanned_, std::string("mu"), std::string("layer")}) {
        if (element.contains(key) && element[key].is_number()) {
          const auto by = element.find("by");  // two of the same mu are told apart
          return fmt::format("{}-{}{}", key, exact(element[key].get<double>()),
                             by != element.end() && by->is_string() ? "-by-" + by->get<std::string>() : "");
        }
      }
      for (const char* key : {"id", "change", "law", "estimator"}) {
        if (element.contains(key) && element[key].is_string()) return element[key].get<std::string>();
      }
    }
    return std::to_string(index + 1);
  }

  std::string unique(const std::string& name) {
    const std::string plain = single_line(name, name.size());
    std::string other = plain;
    for (int copy = 2; !names_.insert(other).second; ++copy) other = fmt::format("{}/{}", plain, copy);
    return other;
  }

  void take(const std::string& name, const Json& value, const Json& standard_error, bool no_power = false) {
    const bool with_error = standard_error.is_number() && !no_power;
    constexpr double rounding = 1e-12;  // of what does not scatter
    const bool is_rounding =
        with_error && std::max(std::abs(value.get<double>()), standard_error.get<double>()) < rounding;
    numbers_.push_back({unique(name),
                        value,
                        with_error ? standard_error : Json(nullptr),
                        is_rounding  ? "0"
                        : with_error ? plain_value_with_error(value.get<double>(), standard_error.get<double>())
                        : no_power   ? significant(value.get<double>(), 3)
                                     : format_number(value, "plain"),
                        no_power,
                        {}});
  }

  std::string scanned_;
  std::vector<NamedNumber> numbers_;
  std::set<std::string> names_;
};

/// A name between \csname and \endcsname, where TeX would carry out a command: what is more than a letter to it becomes
/// a dash.
std::string tex_name(std::string_view name) {
  std::string plain(name);
  std::ranges::replace_if(
      plain,
      [](char c) {
        return static_cast<unsigned char>(c) <= ' ' ||
               std::string_view("\\{}%#$&~^\x7f").find(c) != std::string_view::npos;
      },
      '-');
  return plain;
}

/// Typographic signs as TeX writes them in a formula.
std::string in_tex(std::string text) {
  const auto replace = [&text](std::string_view sign, std::string_view by) {
    for (std::size_t at = text.find(sign); at != std::string::npos; at = text.find(sign, at + by.size())) {
      text.replace(at, sign.size(), by);
    }
  };
  replace("−", "-");
  replace(" × ", " \\times ");
  replace("×", "\\times ");
  // Raised figures stand together, behind a ten.
  constexpr std::array<std::string_view, 11> raised = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹", "⁻"};
  const auto raised_at = [&](std::size_t at) {
    return std::find_if(raised.begin(), raised.end(),
                        [&](std::string_view sign) { return text.compare(at, sign.size(), sign) == 0; });
  };
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (raised_at(at) == raised.end()) continue;
    std::string exponent;
    std::size_t end = at;
    for (auto sign = raised_at(end); end < text.size() && sign != raised.end(); sign = raised_at(end)) {
      const auto figure = sign - raised.begin();
      exponent += figure == 10 ? "-" : std::to_string(figure);
      end += sign->size();
    }
    text.replace(at, end - at, "^{" + exponent + "}");
  }
  return "\\ensuremath{" + text + "}";
}

/// What a paper says of a run. `name` without what lies behind its first stroke is a result, a list or an exponent.
bool is_quoted(const std::string& name, const std::string& scanned) {
  const std::string first = name.substr(0, name.find('/')), last = name.substr(name.rfind('/') + 1);
  const bool exponent = last == "beta" || last == "gamma" || last == "alpha";
  if (first == name) return exponent;
  if (first.starts_with(scanned + "-")) {
    return name == first + '/' + last && (last == "c" || last == "D" || last == "c_thrust");
  }
  if (first == "claims") return last == "measured";
  return first == "mean_exponents" || ((first == "other_windows" || first == "readings") && exponent);
}

/// Whether one part of the name, or several that follow each other, is `part`.
bool has_part(const std::string& name, const std::string& part) {
  return ('/' + name + '/').find('/' + part + '/') != std::string::npos;
}

/// What a name was probably meant to be, that no number has: other capitals, what the glossary says for it (x_p is the
/// peak position), or one of the values that there are.
std::string meant_by(const std::string& name, const std::vector<NamedNumber>& all, const std::string& scanned) {
  std::set<std::string> values, meant = {lower_case(name)};
  for (const GlossaryEntry& entry : glossary()) {
    if (std::ranges::find(entry.names, name) == entry.names.end()) continue;
    for (const std::string& other : entry.names) meant.insert(replaced(other, {{' ', "_"}}));
  }
  for (const NamedNumber& one : all) {
    if (one.name.starts_with(scanned + "-")) values.insert(one.name.substr(0, one.name.find('/')));
    for (const std::string& part : parts_between(one.name, "/")) {
      if (meant.contains(part) || meant.contains(lower_case(part))) return fmt::format("did you mean {}? ", part);
    }
  }
  return name.starts_with(scanned) ? fmt::format("there are {}; ", fmt::join(values, ", ")) : "";
}

std::vector<NamedNumber> chosen(const std::vector<NamedNumber>& all, const NumberChoice& choice,
                                const std::string& scanned) {
  const auto some_of = [&all](const auto& holds) {
    std::vector<NamedNumber> some;
    std::copy_if(all.begin(), all.end(), std::back_inserter(some), holds);
    return some;
  };
  const auto listed = [&](const NamedNumber& one) { return choice.all || is_quoted(one.name, scanned); };
  if (choice.only.empty()) return some_of(listed);
  std::set<std::string> names;
  for (const std::string& part : choice.only) {
    const auto has = [&part](const NamedNumber& one) { return has_part(one.name, part); };
    std::vector<NamedNumber> found = some_of([&](const NamedNumber& one) { return listed(one) && has(one); });
    if (found.empty()) found = some_of(has);
    if (found.empty()) {
      throw InputError("no number has the name {}; {}`granuscope numbers OUT --all --format csv` lists all names", part,
                       meant_by(part, all, scanned));
    }
    for (const NamedNumber& one : found) names.insert(one.name);
  }
  return some_of([&names](const NamedNumber& one) { return names.contains(one.name); });
}

}  // namespace

std::string list_numbers(std::string_view summary, const std::string& format, const NumberChoice& choice) {
  const Json json = Json::parse(shallow_json(std::string(summary)), nullptr, false);
  if (!json.is_object() || !json.contains("results")) {
    throw InputError("this is no summary.json of a run, so that it has no numbers; name the folder of a finished run");
  }
  require_known_schema(json, "summary.json");
  if (format != "tex" && format != "csv" && format != "json")
    throw InputError("there is no format {}; choose tex, csv or json", format);
  NumberList list(scanned_in(json));
  for (const auto& [key, part] : json.items()) {
    if (key != "schema" && key != "figures") list.add(key, part);
  }
  const std::vector<NamedNumber> numbers = chosen(list.numbers(), choice, scanned_in(json));
  if (format == "json") {
    Json all = Json::object();
    for (const NamedNumber& number : numbers) {
      all[number.name] = {{"value", number.value}, {"stderr", number.standard_error}, {"text", number.text}};
    }
    return all.dump(2) + "\n";
  }
  if (format == "csv") {
    CsvTable table({"name", "value", "standard_error", "text"});
    for (const NamedNumber& number : numbers) {
      table.add_cells({number.name, number.value.is_null() ? "nan" : number.value.dump(),
                       number.standard_error.is_null() ? "nan" : number.standard_error.dump(), number.text});
    }
    return table.text();
  }
  std::string text =
      "% Numbers of a run (all: numbers --all). \\granuscope{NAME} writes one with its standard error, in text and in "
      "formulae.\n"
      "\\newcommand{\\granuscope}[1]{\\ifcsname granuscope@\\detokenize{#1}\\endcsname"
      "\\csname granuscope@\\detokenize{#1}\\endcsname\\else\n"
      "  \\errmessage{granuscope has no number of the name #1}\\fi}\n";
  for (const NamedNumber& number : numbers) {
    if (!number.reason.empty()) {
      text += fmt::format("% {} is unknown: {}\n", tex_name(number.name), single_line(number.reason));
      continue;
    }
    text += fmt::format("\\expandafter\\def\\csname granuscope@\\detokenize{{{}}}\\endcsname{{{}}}{}\n",
                        tex_name(number.name), in_tex(number.text), number.no_power ? "% no power law" : "");
  }
  return text;
}

std::string escape_markdown(std::string_view text) {
  return replaced(backslashed(text, "\\`*_{}[]#|~>"), {{'\n', " "}, {'\t', " "}, {'&', "&amp;"}, {'<', "&lt;"}});
}

namespace {

constexpr std::array<std::string_view, 7> joining{"=", "−", "≈", "±", "×", "∝", "≤"};

bool joins(std::string_view word) { return std::ranges::find(joining, word) != joining.end(); }

/// "1/√z" and "xₚ/z": a line could break behind the stroke.
bool short_fraction(std::string_view word) {
  constexpr std::size_t longest = 16;  // bytes; more is a path, or no formula
  return word.size() <= longest && word.find('/') != std::string_view::npos;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(' ', start), text.size());
    words.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return words;
}

}  // namespace

std::string unbroken_formulae(std::string_view text) {
  const std::vector<std::string_view> words = words_of(text);
  std::string html;
  bool inside = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool last = i + 1 == words.size();
    const bool goes_on = !last && (joins(words[i + 1]) || words[i + 1].starts_with('%') || words[i + 1] == ":" ||
                                   words[i + 1] == ";" || (inside && joins(words[i])));
    if ((goes_on || short_fraction(words[i])) && !inside) {
      html += "<span class=\"formula-text\">";
      inside = true;
    }
    html += escape_markup(words[i]);
    if (inside && !goes_on) {
      html += "</span>";
      inside = false;
    }
    if (!last) html += ' ';
  }
  return html;
}

std::string unbroken_words(std::string_view text) {
  constexpr std::size_t longest = 60;  // characters that fit into a line of print in any case
  std::string html;
  for (const std::string_view word : words_of(text)) {
    if (!html.empty()) html += ' ';
    const bool breaks = word.size() > longest || word.find('-') == std::string_view::npos;
    html += breaks ? escape_markup(word) : "<span class=\"word\">" + escape_markup(word) + "</span>";
  }
  return html;
}

}  // namespace granuscope
