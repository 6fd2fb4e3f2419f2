#include "report/page_scope.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "report/escape_markdown.h"
#include "report/number_text.h"
#include "report/page_table.h"
#include "report/unbroken_text.h"
#include "support/clean_text.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// The member or element at a path of names and numbers; null if there is none.
const Json* find(const Json* from, std::string_view path) {
  while (from != nullptr && !path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    const std::string step(path.substr(0, end));
    path.remove_prefix(std::min(end + 1, path.size()));
    if (from->is_object()) {
      from = from->contains(step) ? &from->at(step) : nullptr;
    } else if (from->is_array() && step.find_first_not_of("0123456789") == std::string::npos) {
      const std::size_t index = std::stoul(step);
      from = index < from->size() ? &from->at(index) : nullptr;
    } else {
      from = nullptr;
    }
  }
  return from;
}

/// "c|plain|bare" as name and formats.
struct Request {
  std::string name;
  std::string number_format;  ///< of format_number
  std::string span_class;
  bool bare = false, key = false, formulae = false, words = false;
};

Request request_of(const std::string& tag) {
  std::size_t bar = std::min(tag.find('|'), tag.size());
  Request request;
  request.name = tag.substr(0, bar);
  while (bar < tag.size()) {
    const std::size_t next = std::min(tag.find('|', bar + 1), tag.size());
    const std::string format = tag.substr(bar + 1, next - bar - 1);
    bar = next;
    if (format == "bare") {
      request.bare = true;
    } else if (format == "key") {
      request.key = true;
    } else if (format == "formulae") {
      request.formulae = true;
    } else if (format == "words") {
      request.words = true;
    } else if (format.starts_with("class ")) {
      request.span_class = format.substr(6);
    } else {
      request.number_format = format;
    }
  }
  return request;
}

const std::string* text_of(const Json* overlay) {
  if (overlay == nullptr) return nullptr;
  if (overlay->is_string()) return &overlay->get_ref<const std::string&>();
  return overlay->is_object() && overlay->contains("text") ? &overlay->at("text").get_ref<const std::string&>()
                                                           : nullptr;
}

}  // namespace

bool PageScope::Place::is_overlaid() const {
  return overlay != nullptr && (summary == nullptr || !overlay->is_structured());
}

PageScope::PageScope(const Json& summary, const Json& overlay, Markup markup)
    : here_{"", &summary, &overlay}, markup_(markup) {}

PageScope::PageScope(const PageScope& root, const std::string& pointer, const Json& overlay)
    : here_(root.look_up("$" + pointer)), outer_(&root), markup_(root.markup_) {
  here_.overlay = &overlay;
}

PageScope::PageScope(const PageScope& outer, const Place& place)
    : here_(place), outer_(&outer), markup_(outer.markup_) {}

const PageScope& PageScope::root() const { return outer_ == nullptr ? *this : outer_->root(); }

PageScope::Place PageScope::look_up(const std::string& name) const {
  if (name == ".") return here_;
  if (name == "$") return root().here_;
  if (name.starts_with("$/")) return root().look_up(name.substr(2));
  if (name.starts_with("../")) {
    if (outer_ == nullptr) throw std::logic_error(fmt::format("{}: there is nothing around the whole file", name));
    return outer_->look_up(name.substr(3));
  }
  Place place{here_.pointer + "/" + name, find(here_.summary, name), find(here_.overlay, name)};
  // What the overlay says to stand elsewhere in summary.json, stands there with all that lies below it.
  for (std::size_t end = name.size(); here_.overlay != nullptr; end = name.rfind('/', end - 1)) {
    const Json* referring = find(here_.overlay, name.substr(0, end));
    if (referring != nullptr && referring->is_object() && referring->contains("key")) {
      place.pointer = referring->at("key").get<std::string>() + name.substr(end);
      place.summary = find(root().here_.summary, std::string_view(place.pointer).substr(1));
      if (place.summary == nullptr) throw std::logic_error("summary.json has nothing at " + place.pointer);
      break;
    }
    if (name.rfind('/', end - 1) == std::string::npos) break;
  }
  return place;
}

PageScope::Place PageScope::known(const std::string& name) const {
  Place place = look_up(name);
  if (place.summary == nullptr && place.overlay == nullptr) {
    throw std::logic_error(fmt::format("nothing stands for {{{{{}}}}} at \"{}\"", name, here_.pointer));
  }
  return place;
}

std::string PageScope::raw_text(const std::string& name) const {
  const Request request = request_of(name);
  const Place place = known(request.name);
  if (request.key) return place.pointer;
  if (const std::string* plain = text_of(place.overlay); plain != nullptr) return clean_text(*plain);
  return format_number(place.is_overlaid() ? *place.overlay : *place.summary, request.number_format);
}

std::string PageScope::text(const std::string& name) const {
  const Request request = request_of(name);
  const std::string raw = raw_text(name);
  if (markup_ == Markup::markdown) return escape_markdown(raw);
  std::string html = request.formulae ? unbroken_formulae(raw)
                     : request.words  ? unbroken_words(raw)
                                      : escape_markup(raw);
  const Place place = known(request.name);
  if (request.bare || request.key || place.is_overlaid()) return html;
  const std::string with_class = request.span_class.empty() ? "" : fmt::format(" class=\"{}\"", request.span_class);
  return fmt::format("<span{} data-key=\"{}\">{}</span>", with_class, escape_markup(place.pointer), html);
}

PageScope::Place PageScope::element(const Place& list, std::size_t i) const {
  Place place{fmt::format("{}/{}", list.pointer, i), nullptr, nullptr};
  const bool own = list.summary != nullptr && list.summary->is_array();
  if (own) place.summary = &list.summary->at(i);
  if (list.overlay == nullptr) return place;
  place.overlay = &list.overlay->at(i);
  if (!own && place.overlay->is_object() && place.overlay->contains("key")) {
    place.pointer = place.overlay->at("key").get<std::string>();
    place.summary = find(root().here_.summary, std::string_view(place.pointer).substr(1));
    if (place.summary == nullptr) throw std::logic_error("summary.json has nothing at " + place.pointer);
  }
  return place;
}

void PageScope::enter(const std::string& name, Missing missing, const Write& write) const {
  if (missing == Missing::means_not_there) {
    const Place place = look_up(name);
    if (place.summary == nullptr && place.overlay == nullptr) return;
  }
  if (const std::size_t equals = name.find('='); equals != std::string::npos) {
    if (raw_text(name.substr(0, equals)) == name.substr(equals + 1)) write(*this);
    return;
  }
  const Place place = known(name);
  const Json& value = place.is_overlaid() ? *place.overlay : *place.summary;
  if (value.is_array()) {
    if (place.overlay != nullptr && place.overlay->size() != value.size()) {
      throw std::logic_error(fmt::format("the overlay of {} has another length", place.pointer));
    }
    for (std::size_t i = 0; i < value.size(); ++i) write(PageScope(*this, element(place, i)));
  } else if (value.is_object()) {
    if (!value.empty()) write(PageScope(*this, place));
  } else {
    const bool no_text = value.is_string() && value.get_ref<const std::string&>().empty();
    const bool nothing = value.is_null() || value == false || no_text || (value.is_number_integer() && value == 0);
    if (!nothing) write(*this);
  }
}

std::string PageScope::part(const std::string& name) const {
  return name.ends_with(".table") ? page_table(name, *this) : TemplateScope::part(name);
}

bool PageScope::has(const std::string& name) const {
  if (name.starts_with('^')) return !has(name.substr(1));
  bool there = false;
  const bool optional = name.ends_with('?');
  enter(optional ? name.substr(0, name.size() - 1) : name, optional ? Missing::means_not_there : Missing::is_an_error,
        [&there](const TemplateScope&) { there = true; });
  return there;
}

const Json& PageScope::value(const std::string& name) const {
  const Place place = known(name);
  return place.summary != nullptr ? *place.summary : *place.overlay;
}

}  // namespace granuscope
