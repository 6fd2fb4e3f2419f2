#include "render/labels.h"

#include <fmt/format.h>

#include <functional>
#include <map>
#include <stdexcept>
#include <utility>

#include "support/template_file.h"

namespace granuscope {
namespace {

constexpr const char* file_name = "pictures/labels.txt";
constexpr std::string_view separator = " = ";

std::map<std::string, std::string, std::less<>> parse(std::string_view text) {
  std::map<std::string, std::string, std::less<>> labels;
  while (!text.empty()) {
    const auto end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    const auto between = line.find(separator);
    if (between == std::string_view::npos) {
      throw std::logic_error(fmt::format("templates/{}: '{}' does not read `name = text`", file_name, line));
    }
    labels.emplace(line.substr(0, between), line.substr(between + separator.size()));
  }
  return labels;
}

}  // namespace

const std::string& label(std::string_view name) {
  static const auto labels = parse(template_file(file_name));
  const auto found = labels.find(name);
  if (found == labels.end()) throw std::logic_error(fmt::format("templates/{} has no label '{}'", file_name, name));
  return found->second;
}

}  // namespace granuscope
