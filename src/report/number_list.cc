#include "report/number_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <vector>

#include "report/number_text.h"
#include "report/reason_notes.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

struct NamedNumber {
  std::string name;
  Json value, standard_error;  ///< the latter null where there is none
  std::string text;
};

class NumberList {
 public:
  /// `scanned`: what tells results apart.
  explicit NumberList(std::string scanned) : scanned_(std::move(scanned)) {}

  void add(const std::string& name, const Json& json) {
    if (json.is_object() && json.contains("value") && json.contains("stderr")) {
      if (json["value"].is_number()) take(name, json["value"], json["stderr"]);
    } else if (json.is_object()) {
      for (const auto& [key, inside] : json.items()) {
        if (key == "measured" && json.contains("stderr") && inside.is_number()) {
          take(below(name, key), inside, json["stderr"]);
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
          return fmt::format("{}-{}", key, exact(element[key].get<double>()));
        }
      }
      for (const char* key : {"id", "change", "law", "estimator"}) {
        if (element.contains(key) && element[key].is_string()) return element[key].get<std::string>();
      }
    }
    return std::to_string(index + 1);
  }

  void take(std::string name, const Json& value, const Json& standard_error) {
    std::string unique = name;
    for (int copy = 2; !names_.insert(unique).second; ++copy) unique = fmt::format("{}/{}", name, copy);
    const bool with_error = standard_error.is_number();
    numbers_.push_back({unique, value, with_error ? standard_error : Json(nullptr),
                        with_error ? plain_value_with_error(value.get<double>(), standard_error.get<double>())
                                   : format_number(value, "plain")});
  }

  std::string scanned_;
  std::vector<NamedNumber> numbers_;
  std::set<std::string> names_;
};

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

}  // namespace

std::string list_numbers(std::string_view summary, const std::string& format) {
  const Json json = Json::parse(summary, nullptr, false);
  if (!json.is_object() || !json.contains("results")) {
    throw InputError("this is no summary.json of a run, so that it has no numbers; name the folder of a finished run");
  }
  NumberList list(scanned_in(json));
  for (const auto& [key, part] : json.items()) {
    if (key != "schema" && key != "figures") list.add(key, part);
  }
  if (format == "json") {
    Json all = Json::object();
    for (const NamedNumber& number : list.numbers()) {
      all[number.name] = {{"value", number.value}, {"stderr", number.standard_error}, {"text", number.text}};
    }
    return all.dump(2) + "\n";
  }
  if (format == "csv") {
    std::string text = "name,value,standard_error,text\n";
    for (const NamedNumber& number : list.numbers()) {
      text += fmt::format("{},{},{},{}\n", number.name, number.value.dump(),
                          number.standard_error.is_null() ? "" : number.standard_error.dump(), number.text);
    }
    return text;
  }
  if (format != "tex") throw InputError(fmt::format("there is no format {}; choose tex, csv or json", format));
  std::string text =
      "% Every number of a run. \\granuscope{NAME} writes one with its standard error, in text and in formulae.\n"
      "\\newcommand{\\granuscope}[1]{\\ifcsname granuscope@#1\\endcsname\\csname granuscope@#1\\endcsname\\else\n"
      "  \\errmessage{granuscope has no number of the name #1}\\fi}\n";
  for (const NamedNumber& number : list.numbers()) {
    text +=
        fmt::format("\\expandafter\\def\\csname granuscope@{}\\endcsname{{{}}}\n", number.name, in_tex(number.text));
  }
  return text;
}

}  // namespace granuscope
