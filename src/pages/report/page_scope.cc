#include "report/page_scope.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "plot/gnuplot.h"
#include "report/number_text.h"
#include "sampling/sampler_spec.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
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

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

bool is_known(const Json& number) {
  return number.is_number() || (number.is_object() && number.contains("value") && number.at("value").is_number());
}

const std::string* text_of(const Json* overlay) {
  if (overlay == nullptr) return nullptr;
  if (overlay->is_string()) return &overlay->get_ref<const std::string&>();
  return overlay->is_object() && overlay->contains("text") ? &overlay->at("text").get_ref<const std::string&>()
                                                           : nullptr;
}

}  // namespace

std::string escape_tex(std::string_view text) {
  std::string escaped = replaced(single_line(text, text.size()), {{'\\', "\\textbackslash{}"},
                                                                  {'^', "\\textasciicircum{}"},
                                                                  {'~', "\\textasciitilde{}"},
                                                                  {'{', "\\{"},
                                                                  {'}', "\\}"},
                                                                  {'$', "\\$"},
                                                                  {'&', "\\&"},
                                                                  {'#', "\\#"},
                                                                  {'%', "\\%"},
                                                                  {'_', "\\_"},
                                                                  {'<', "\\ensuremath{<}"},
                                                                  {'>', "\\ensuremath{>}"}});
  std::string known;
  for (const char c : signs_in_tex(std::move(escaped))) {
    const auto byte = static_cast<unsigned char>(c);
    const auto before = known.empty() ? 0U : static_cast<unsigned char>(known.back());
    const bool continues = byte >= 0x80 && byte < 0xC0;
    if (byte < 0x80 || byte == 0xC3 || (continues && before == 0xC3)) {  // ASCII, and letters of Latin-1
      known += c;
    } else if (!continues) {
      known += '?';
    }
  }
  return known;
}

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
  if (markup_ == Markup::tex) return escape_tex(raw);
  if (markup_ == Markup::plain) return single_line(raw, raw.size());
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

std::optional<bool> PageScope::condition(const std::string& name, Missing missing) const {
  if (const std::size_t relation = name.find_first_of("=!<>"); relation != std::string::npos) {
    const bool other = name[relation] == '!';
    const std::string left = name.substr(0, relation), right = name.substr(relation + (other ? 2 : 1));
    if (missing == Missing::means_not_there) {
      const Place place = look_up(left);
      if (place.summary == nullptr && place.overlay == nullptr) return false;
    }
    if (other || name[relation] == '=') return (raw_text(left) == right) != other;
    const Json& number = value(left);
    if (!number.is_number()) throw std::logic_error(fmt::format("{{{{#{}}}}}: {} is no number", name, left));
    return name[relation] == '<' ? number.get<double>() < std::stod(right) : number.get<double>() > std::stod(right);
  }
  const std::vector<std::string> words = words_of(name);
  if (words.size() < 2) return std::nullopt;
  if (words[0] == "known") {
    return std::all_of(words.begin() + 1, words.end(), [&](const std::string& one) { return is_known(value(one)); });
  }
  if (words[0] != "any" || (words.size() > 2 && words[2] != "known")) {
    throw std::logic_error(fmt::format("{{{{#{}}}}} is neither a name nor a condition", name));
  }
  const Json& list = value(words[1]);
  if (words.size() == 2) return !list.empty();
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t k = 3; k < words.size(); ++k) {
      if (is_known(value(fmt::format("{}/{}/{}", words[1], i, words[k])))) return true;
    }
  }
  return false;
}

void PageScope::enter(const std::string& name, Missing missing, const Write& write) const {
  if (const std::optional<bool> holds = condition(name, missing)) {
    if (*holds) write(*this);
    return;
  }
  if (missing == Missing::means_not_there) {
    const Place place = look_up(name);
    if (place.summary == nullptr && place.overlay == nullptr) return;
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

namespace {

/// "a, b and c".
std::string enumerated(const Json& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i].get<std::string>();
  }
  return text;
}

}  // namespace

std::string scanned_in(const Json& summary) {
  const auto scan = summary.find("scan");
  const bool told =
      scan != summary.end() && scan->is_object() && scan->contains("parameter") && scan->at("parameter").is_string();
  return told ? scan->at("parameter").get<std::string>() : friction_parameter().name;
}

std::string place_of_scanned(const Json& summary, std::size_t result) {
  return fmt::format("/results/{}/{}", result, scanned_in(summary));
}

std::string at_scanned(const Json& summary, std::size_t result) {
  return fmt::format("{} = {}", summary.at("scan").at("symbol").get<std::string>(),
                     format_number(summary.at(Json::json_pointer(place_of_scanned(summary, result)))));
}

void add_reason(Json& notes, const Json& summary, const std::string& pointer, const std::string& name,
                const std::string& place) {
  const Json& estimate = summary.at(Json::json_pointer(pointer));
  if (!estimate.contains("reason")) return;
  auto note = std::find_if(notes.begin(), notes.end(),
                           [&](const Json& known) { return known.at("why") == estimate.at("reason"); });
  if (note == notes.end()) {
    notes.push_back(
        {{"why", estimate.at("reason")}, {"reason", {{"key", pointer + "/reason"}}}, {"places", Json::object()}});
    note = std::prev(notes.end());
  }
  Json& names = (*note)["places"][place];
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

namespace {

/// " at μ = 0.1 and 0.3" of " at μ = 0.1" and " at μ = 0.3"; those that differ before the value stay apart.
std::string joined_places(const std::string& what, const std::vector<std::string>& places) {
  const std::string head = places.front().substr(0, places.front().rfind("= ") + 1);
  if (places.size() == 1 ||
      !std::ranges::all_of(places, [&](const std::string& one) { return !head.empty() && one.starts_with(head); })) {
    return fmt::format("{}{}", what, fmt::join(places, "; " + what));
  }
  Json values = Json::array();
  for (const std::string& one : places) values.push_back(one.substr(head.size() + 1));
  return fmt::format("{}{} {}", what, head, enumerated(values));
}

}  // namespace

void finish_notes(Json& notes) {
  for (Json& note : notes) {
    std::vector<std::pair<std::string, std::vector<std::string>>> groups;  // what is unknown, and where
    std::size_t names = 0;
    for (const auto& [place, named] : note.at("places").items()) {
      const std::string which = enumerated(named);
      if (groups.empty() || groups.back().first != which) groups.push_back({which, {}});
      groups.back().second.push_back(place);
      names += named.size();
    }
    std::string what;
    for (const auto& [which, places] : groups) what += (what.empty() ? "" : "; ") + joined_places(which, places);
    note.erase("places");
    note["what"] = what;
    note["are"] = names == 1 ? "is" : "are";
  }
}

namespace {

struct Column {
  std::string title, cell, only_if;
  std::string classes;        ///< of its cells
  std::string title_classes;  ///< of its title
  bool heading = false, once = false;
};

/// Rows with the same columns.
struct Block {
  std::vector<std::string> rows;  ///< a list, and lists within its elements
  std::string where, after, end;
  std::vector<std::string> group;
  std::vector<Column> columns;
};

struct TableForm {
  std::string caption, classes;
  std::vector<Block> blocks;
};

class TableReader {
 public:
  explicit TableReader(std::string file) : file_(std::move(file)) {}

  TableForm read(std::string_view text) {
    std::istringstream lines{std::string(text)};
    std::string entry;
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      if (line.starts_with(' ')) {
        if (entry.empty()) fail("there is no line that this one could go on with");
        entry.append("\n").append(trimmed(line));
        continue;
      }
      take(entry);
      entry = line.starts_with('#') ? "" : line;
      entry_line_ = line_;
    }
    take(entry);
    entry_line_ = line_;
    if (form_.caption.empty()) fail("the table has no caption");
    if (form_.blocks.empty()) fail("the table has no rows");
    for (const Block& block : form_.blocks) {
      if (block.columns.empty()) fail("there are rows without a column");
    }
    return form_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::logic_error(fmt::format("templates/{}:{}: {}", file_, entry_line_, what));
  }

  void take(const std::string& entry) {
    if (trimmed(entry).empty()) return;
    if (entry.find("::") != std::string::npos) {
      take_column(parts_between(entry, "::"));
      return;
    }
    const std::size_t colon = entry.find(':');
    if (colon == std::string::npos) fail("neither \"key: value\" nor \"title :: kind :: cell\"");
    const std::string key = entry.substr(0, colon), value(trimmed(std::string_view(entry).substr(colon + 1)));
    if (key == "rows") {
      form_.blocks.emplace_back().rows = parts_between(value, ">");
      return;
    }
    if (key == "caption" || key == "class") {
      (key == "class" ? form_.classes : form_.caption) = value;
      return;
    }
    if (form_.blocks.empty()) fail(fmt::format("\"{}\" before \"rows\", or not known", key));
    Block& block = form_.blocks.back();
    if (!block.columns.empty()) fail(fmt::format("\"{}\" behind the first column", key));
    if (key == "group") {
      block.group = words_of(value);
    } else if (key == "where" || key == "after" || key == "end") {
      (key == "where" ? block.where : key == "after" ? block.after : block.end) = value;
    } else {
      fail(fmt::format("\"{}\" is none of caption, class, rows, where, group, after, end", key));
    }
  }

  void take_column(const std::vector<std::string>& fields) {
    if (form_.blocks.empty()) fail("a column before \"rows\"");
    if (fields.size() < 3 || fields.size() > 4) fail("a column is \"title :: kind :: cell\", or \":: when\" behind it");
    Column column{fields[0], fields[2], fields.size() == 4 ? fields[3] : "", "", ""};
    const std::vector<std::string> words = words_of(fields[1]);
    const auto is = [&](const char* word) { return std::ranges::find(words, word) != words.end(); };
    for (const std::string& word : words) {
      constexpr std::array known{"text", "number", "main", "name", "after", "heading", "once"};
      if (std::ranges::find(known, word) != known.end()) continue;
      fail(fmt::format("\"{}\" is none of {}", word, fmt::join(known, ", ")));
    }
    column.heading = is("heading");
    column.once = is("once");
    const std::string number = is("number") ? "num" : "", after = is("after") ? " after" : "";
    column.classes = trimmed(number + (is("main") ? " main" : "") + (is("name") ? " name" : "") + after);
    column.title_classes = trimmed(number + after);
    form_.blocks.back().columns.push_back(column);
  }

  std::string file_;
  int line_ = 0, entry_line_ = 0;
  TableForm form_;
};

std::string class_attribute(const std::string& classes) {
  return classes.empty() ? "" : fmt::format(" class=\"{}\"", classes);
}

class TableWriter {
 public:
  TableWriter(const TableForm& form, const PageScope& place) : form_(form), place_(place) {}

  std::string write() {
    for (const Block& block : form_.blocks) write_block(block);
    if (html_.empty()) return "";
    const std::string caption = fill_template(form_.caption, place_);
    return fmt::format(
        "<div class=\"wide\" role=\"group\" aria-label=\"Table\" tabindex=\"0\">\n<table{}>\n<caption><span "
        "class=\"caption\">{}</span></caption>\n{}</tbody>\n</table>\n"
        "</div>\n",
        class_attribute(form_.classes), caption, html_);
  }

 private:
  void write_block(const Block& block) {
    columns_.clear();
    for (const Column& column : block.columns) {
      if (column.only_if.empty() || place_.has(column.only_if)) columns_.push_back(column);
    }
    titled_ = false;
    last_group_.clear();
    visit(block, place_, 0);
    if (titled_) html_ += fill_template(block.end, place_);
    if (titled_ && !block.end.empty()) html_ += '\n';
  }

  /// Goes down the lists of the rows.
  void visit(const Block& block, const PageScope& scope, std::size_t depth) {
    if (depth == block.rows.size()) {
      if (block.where.empty() || scope.has(block.where)) write_row(block, scope);
      return;
    }
    scope.enter(block.rows[depth], TemplateScope::Missing::is_an_error,
                [&](const TemplateScope& inside) { visit(block, dynamic_cast<const PageScope&>(inside), depth + 1); });
  }

  /// The titles: of the table's first block its head, of another a row.
  void write_titles() {
    const bool head = html_.empty();
    html_ += head ? "<thead><tr>" : "</tbody>\n<tbody>\n<tr class=\"first\">";
    for (const Column& column : columns_) {
      const std::string title = fill_template(column.title, place_);
      html_ += title.empty() ? "<td></td>"
                             : fmt::format("<th scope=\"col\"{}>{}</th>", class_attribute(column.title_classes), title);
    }
    html_ += head ? "</tr></thead>\n<tbody>\n" : "</tr>\n";
  }

  void write_row(const Block& block, const PageScope& row) {
    std::vector<Json> group;
    for (const std::string& name : block.group) group.push_back(row.value(name));
    const bool first = !titled_ || group != last_group_;
    if (!titled_) {
      write_titles();
    } else if (first) {
      html_ += "</tbody>\n<tbody>\n";
    }
    titled_ = true;
    last_group_ = group;
    html_ += first && !group.empty() ? "<tr class=\"first\">" : "<tr>";
    for (const Column& column : columns_) {
      if (column.once && !first) {
        html_ += "<td></td>";
        continue;
      }
      const std::string cell(trimmed(fill_template(column.cell, row))), classes = class_attribute(column.classes);
      html_ += column.heading ? fmt::format("<th scope=\"row\"{}>{}</th>", classes, cell)
                              : fmt::format("<td{}>{}</td>", classes, cell);
    }
    html_ += "</tr>\n";
    if (!block.after.empty()) html_ += fill_template(block.after, row);
  }

  const TableForm& form_;
  const PageScope& place_;
  std::vector<Column> columns_;  ///< of the block
  bool titled_ = false;          ///< the block has a row
  std::vector<Json> last_group_;
  std::string html_;
};

}  // namespace

std::string page_table(const std::string& file, const PageScope& place) {
  return page_table(file, template_file(file), place);
}

std::string page_table(const std::string& file, std::string_view text, const PageScope& place) {
  const TableForm form = TableReader(file).read(text);
  try {
    return TableWriter(form, place).write();
  } catch (const std::logic_error& error) {
    throw std::logic_error(fmt::format("templates/{}: {}", file, error.what()));
  }
}

}  // namespace granuscope
