#include "report/page_reader.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace granuscope::synthetic {

namespace {

using Json = nlohmann::json;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

std::string resolved(std::string text) {
  for (const auto& [reference, character] : std::vector<std::pair<std::string, std::string>>{
           {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&apos;", "'"}, {"&amp;", "&"}}) {
    text = replaced(text, reference, character);
  }
  return text;
}

/// Text content of the element whose start tag ends at `at`, nested elements of the same page included.
std::string content_from(const std::string& html, std::size_t at) {
  std::string text;
  int depth = 1;
  while (at < html.size() && depth > 0) {
    if (html[at] != '<') {
      text += html[at++];
      continue;
    }
    depth += html[at + 1] == '/' ? -1 : 1;
    at = html.find('>', at) + 1;
  }
  return resolved(text);
}

std::string printed(const char* format, int digits, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, digits, value);
  std::string result = text;
  const bool negative = result[0] == '-';
  if (negative) result.erase(0, 1);
  if (negative && result.find_first_not_of("0.") != std::string::npos) result.insert(0, "\xE2\x88\x92");
  return result;
}

/// 0.0792(41): two digits of the error, the value to the same decimals.
std::string value_and_error(double value, double error) {
  if (error == 0) return value == 0 ? "0" : printed("%#.*g", 6, value);
  char scientific[32];
  std::snprintf(scientific, sizeof scientific, "%.1e", error);  // "4.1e-03"
  const int exponent = std::atoi(scientific + 4);
  const std::string two_digits = {scientific[0], scientific[2]};
  if (exponent >= 1) return "the test does not know how to write errors of 10 and more";
  if (exponent == 0) return printed("%.*f", 1, value) + "(" + scientific[0] + "." + scientific[2] + ")";
  return printed("%.*f", 1 - exponent, value) + "(" + two_digits + ")";
}

int from_superscript(const std::string& text) {
  static const char* const digits[] = {"\xE2\x81\xB0", "\xC2\xB9",     "\xC2\xB2",     "\xC2\xB3",     "\xE2\x81\xB4",
                                       "\xE2\x81\xB5", "\xE2\x81\xB6", "\xE2\x81\xB7", "\xE2\x81\xB8", "\xE2\x81\xB9"};
  std::string plain = replaced(text, "\xE2\x81\xBB", "-");
  for (int digit = 0; digit < 10; ++digit) plain = replaced(plain, digits[digit], std::to_string(digit));
  return std::stoi(plain);
}

/// A plain number is right if it is the value rounded to as many decimals as it shows, at least two digits of it or
/// all.
bool shows(const std::string& text, double value) {
  static const std::string power = " \xC3\x97 10";  // "3.2 x 10" and then an exponent in superscript digits
  if (const std::size_t at = text.find(power); at != std::string::npos) {
    const int exponent = from_superscript(text.substr(at + power.size()));
    return shows(text.substr(0, at), value / std::pow(10, exponent));
  }
  const std::size_t point = text.find('.');
  const int decimals = point == std::string::npos ? 0 : static_cast<int>(text.size() - point - 1);
  return text == printed("%.*f", decimals, value) &&
         (value == 0 || std::abs(std::stod(replaced(text, "\xE2\x88\x92", "-")) / value - 1) < 0.6);
}

/// The second bracket of 0.0792(41)(12): a systematic error in the last digits that two digits of the other give.
std::string in_last_digits(double error, double systematic) {
  char scientific[32];
  std::snprintf(scientific, sizeof scientific, "%.1e", error);
  const int decimals = 1 - std::atoi(scientific + 4);
  const double units = systematic * std::pow(10, decimals);
  return decimals == 1 ? printed("%.*f", 1, systematic) : printed("%.*f", 0, units < 1 ? 1 : units);
}

std::string difference(const Json& summary, const std::string& key, const std::string& text) {
  const Json::json_pointer pointer(key);
  if (!summary.contains(pointer)) return key + " leads nowhere";
  const Json& value = summary.at(pointer);
  std::string expected;
  if (value.is_string()) {
    expected = value.get<std::string>();
  } else if (value.is_null()) {
    expected = "n/a";
  } else if (value.is_number_integer()) {
    expected = value.dump();
  } else if (key.ends_with("/systematic") && text.find('\xC3') == std::string::npos &&
             text.find("0.0") == std::string::npos) {
    expected = in_last_digits(summary.at(pointer.parent_pointer()).at("stderr"), value);
  } else if (value.is_number() && key.ends_with("/measured") && text.find('(') != std::string::npos) {
    expected = value_and_error(value, summary.at(pointer.parent_pointer()).at("stderr"));  // of a claim
  } else if (value.is_number()) {
    if (shows(text, value.get<double>())) return "";
    expected = value.dump();
  } else if (value.is_object() && value.contains("stderr")) {
    // Without an error where the points follow no power law.
    if (value.contains("power_law") && value["power_law"] == false && shows(text, value["value"].get<double>())) {
      return "";
    }
    expected = value["value"].is_null() ? "n/a" : value_and_error(value["value"], value["stderr"]);
  } else {
    return key + " is neither a number nor a text";
  }
  return text == expected ? "" : key + ": the page shows \"" + text + "\", expected \"" + expected + "\"";
}

}  // namespace

std::vector<std::pair<std::string, std::string>> keyed_texts(const std::string& html) {
  const std::string mark = " data-key=\"";
  std::vector<std::pair<std::string, std::string>> found;
  for (std::size_t at = html.find(mark); at != std::string::npos; at = html.find(mark, at + 1)) {
    const std::size_t start = at + mark.size();
    const std::size_t end = html.find('"', start);
    found.emplace_back(resolved(html.substr(start, end - start)), content_from(html, html.find('>', end) + 1));
  }
  return found;
}

std::vector<std::string> differences(const std::string& html, const std::string& summary) {
  const Json numbers = Json::parse(summary);
  std::vector<std::string> lines;
  for (const auto& [key, text] : keyed_texts(html)) {
    const std::string line = difference(numbers, key, text);
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

}  // namespace granuscope::synthetic
