#include "plot/fill_in.h"

#include <fmt/format.h>

#include <set>
#include <stdexcept>
#include <vector>

namespace granuscope {

namespace {

const std::string& text_for(const Gaps& gaps, const std::string& name) {
  const auto found = gaps.find(name);
  if (found == gaps.end()) throw std::logic_error(fmt::format("plot template: no text for {{{{{}}}}}", name));
  return found->second;
}

struct Section {
  std::string name;
  bool shown = false;
};

}  // namespace

std::string fill_in(std::string_view text, const Gaps& gaps) {
  std::string filled;
  std::vector<Section> open;
  std::set<std::string> asked;
  const auto shown = [&open] { return open.empty() || open.back().shown; };

  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t start = text.find("{{", at);
    if (shown()) filled += text.substr(at, start - at);
    if (start == std::string_view::npos) break;
    const std::size_t end = text.find("}}", start);
    if (end == std::string_view::npos) throw std::logic_error("plot template: a {{ is not closed");
    std::string name(text.substr(start + 2, end - start - 2));
    const char kind = name.empty() ? ' ' : name.front();
    if (kind == '#' || kind == '^' || kind == '/') name.erase(0, 1);
    at = end + 2;
    if (kind == '/') {
      if (open.empty() || open.back().name != name) {
        throw std::logic_error(fmt::format("plot template: section {} is closed but not open", name));
      }
      open.pop_back();
    } else {
      const std::string& value = text_for(gaps, name);
      asked.insert(name);
      if (kind == '#' || kind == '^') {
        open.push_back({name, shown() && value.empty() == (kind == '^')});
      } else if (shown()) {
        filled += value;
      }
    }
    // A section's tag alone on its line leaves no empty line behind.
    const bool section_tag = kind == '#' || kind == '^' || kind == '/';
    const bool line_starts_here = start == 0 || text[start - 1] == '\n';
    if (section_tag && line_starts_here && at < text.size() && text[at] == '\n') ++at;
  }
  if (!open.empty()) throw std::logic_error(fmt::format("plot template: section {} is not closed", open.back().name));
  for (const auto& [name, value] : gaps) {
    if (!asked.contains(name)) throw std::logic_error(fmt::format("plot template: nothing asks for {}", name));
  }
  return filled;
}

}  // namespace granuscope
