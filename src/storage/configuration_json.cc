#include "storage/configuration_json.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace granuscope {
namespace {

/// JSON wants a digit first, or a minus and a digit, and knows neither inf nor nan nor leading zeros.
bool is_json_number(std::string_view text) {
  const std::string_view digits = text.starts_with('-') ? text.substr(1) : text;
  if (digits.empty() || digits.front() < '0' || digits.front() > '9') return false;
  if (digits.size() > 1 && digits.front() == '0' && digits[1] >= '0' && digits[1] <= '9') return false;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && text.back() != '.';
}

std::string json_string(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

std::string configuration_json(std::string_view lines) {
  std::string json;
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    lines.remove_prefix(line.size() < lines.size() ? line.size() + 1 : line.size());
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view value = line.substr(equals + 1);
    const bool plain = value == "true" || value == "false" || is_json_number(value);
    json += fmt::format("{}{}: {}", json.empty() ? "" : ", ", json_string(line.substr(0, equals)),
                        plain ? std::string(value) : json_string(value));
  }
  return "{" + json + "}";
}

}  // namespace granuscope
