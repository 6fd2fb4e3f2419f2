#include "report/mustache_page.h"

#include <fmt/format.h>

#include <kainjow/mustache.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;
namespace mustache = kainjow::mustache;

[[noreturn]] void fail(const std::string& what) { throw std::logic_error("report template: " + what); }

struct Tag {
  char kind = ' ';  ///< '#', '^', '/', or ' ' for a variable
  std::string name;
};

std::vector<Tag> tags_of(std::string_view text) {
  std::vector<Tag> tags;
  for (std::size_t start = text.find("{{"); start != std::string_view::npos; start = text.find("{{", start)) {
    const bool triple = text.substr(start).starts_with("{{{");
    const std::string_view closing = triple ? "}}}" : "}}";
    const std::size_t inside = start + closing.size();
    const std::size_t end = text.find(closing, inside);
    if (end == std::string_view::npos) fail("a {{ is not closed");
    std::string content(text.substr(inside, end - inside));
    start = end + closing.size();
    if (content.starts_with('!')) continue;
    Tag tag;
    if (!content.empty() && std::string_view("#^/&").find(content.front()) != std::string_view::npos) {
      tag.kind = content.front() == '&' ? ' ' : content.front();
      content.erase(0, 1);
    }
    tag.name = content;
    tags.push_back(tag);
  }
  return tags;
}

class KeyCheck {
 public:
  KeyCheck(std::vector<Tag> tags, const Json& values) : tags_(std::move(tags)) {
    matching_end();
    contexts_.push_back(&values);
    visit(0, tags_.size());
  }

 private:
  /// Finds for each opening tag its closing one.
  void matching_end() {
    ends_.resize(tags_.size());
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < tags_.size(); ++i) {
      if (tags_[i].kind == '#' || tags_[i].kind == '^') open.push_back(i);
      if (tags_[i].kind != '/') continue;
      if (open.empty() || tags_[open.back()].name != tags_[i].name) fail("{{/" + tags_[i].name + "}} closes nothing");
      ends_[open.back()] = i;
      open.pop_back();
    }
    if (!open.empty()) fail("{{#" + tags_[open.back()].name + "}} is not closed");
  }

  const Json& look_up(const std::string& name) const {
    if (name == ".") return *contexts_.back();
    for (auto context = contexts_.rbegin(); context != contexts_.rend(); ++context) {
      if ((*context)->is_object() && (*context)->contains(name)) return (*context)->at(name);
    }
    fail("no value for {{" + name + "}}");
  }

  void visit_with(const Json& context, std::size_t begin, std::size_t end) {
    contexts_.push_back(&context);
    visit(begin, end);
    contexts_.pop_back();
  }

  void visit(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Tag& tag = tags_[i];
      const Json& value = look_up(tag.name);
      if (tag.kind == ' ') {
        if (!value.is_string()) fail("{{" + tag.name + "}} is not a text");
        continue;
      }
      visit_section(tag, value, i + 1, ends_[i]);
      i = ends_[i];
    }
  }

  void visit_section(const Tag& tag, const Json& value, std::size_t begin, std::size_t end) {
    if (!value.is_boolean() && !value.is_structured())
      fail("section " + tag.name + " is neither a list, object nor yes/no");
    const bool shown = value.is_boolean() ? value.get<bool>() : !value.empty();
    if (shown != (tag.kind == '#')) return;
    if (value.is_array() && shown) {
      for (const Json& element : value) visit_with(element, begin, end);
    } else {
      visit_with(value, begin, end);
    }
  }

  std::vector<Tag> tags_;
  std::vector<std::size_t> ends_;
  std::vector<const Json*> contexts_;
};

mustache::data to_mustache(const Json& json) {
  if (json.is_boolean())
    return json.get<bool>() ? mustache::data(mustache::data::type::bool_true)
                            : mustache::data(mustache::data::type::bool_false);
  if (json.is_string()) return mustache::data(json.get<std::string>());
  if (json.is_array()) {
    mustache::data list(mustache::data::type::list);
    for (const Json& element : json) list.push_back(to_mustache(element));
    return list;
  }
  if (!json.is_object()) fail("a value is neither text, yes/no, list nor object");
  // An empty object stands for "not there", as an empty list does.
  if (json.empty()) return mustache::data(mustache::data::type::bool_false);
  mustache::data object(mustache::data::type::object);
  for (const auto& [name, value] : json.items()) object.set(name, to_mustache(value));
  return object;
}

}  // namespace

void require_all_keys(std::string_view page_template, const Json& values) {
  const KeyCheck check(tags_of(page_template), values);
}

std::string fill_page(std::string_view page_template, const Json& values) {
  require_all_keys(page_template, values);
  mustache::mustache page{std::string(page_template)};
  if (!page.is_valid()) fail(page.error_message());
  std::string text = page.render(to_mustache(values));
  if (!page.error_message().empty()) fail(page.error_message());
  return text;
}

}  // namespace granuscope
