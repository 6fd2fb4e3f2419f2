#include "report/page_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "support/template_file.h"

namespace granuscope {

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

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \n"), last = text.find_last_not_of(" \n");
  return first == std::string_view::npos ? "" : std::string(text.substr(first, last - first + 1));
}

std::vector<std::string> split(std::string_view text, std::string_view separator) {
  std::vector<std::string> parts;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(separator, start), text.size());
    parts.push_back(trimmed(text.substr(start, end - start)));
    start = end + separator.size();
  }
  return parts;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

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
        entry += "\n" + trimmed(line);
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
      take_column(split(entry, "::"));
      return;
    }
    const std::size_t colon = entry.find(':');
    if (colon == std::string::npos) fail("neither \"key: value\" nor \"title :: kind :: cell\"");
    const std::string key = entry.substr(0, colon), value = trimmed(std::string_view(entry).substr(colon + 1));
    if (key == "rows") {
      form_.blocks.emplace_back().rows = split(value, ">");
      return;
    }
    if (key == "caption" || key == "class") {
      (key == "class" ? form_.classes : form_.caption) = value;
      return;
    }
    if (form_.blocks.empty()) fail(fmt::format("\"{}\" before \"rows\", or not known", key));
    Block& block = form_.blocks.back();
    if (!block.columns.empty()) fail(fmt::format("\"{}\" behind the first column", key));
    if (key == "where") {
      block.where = value;
    } else if (key == "group") {
      block.group = words_of(value);
    } else if (key == "after") {
      block.after = value;
    } else if (key == "end") {
      block.end = value;
    } else {
      fail(fmt::format("\"{}\" is none of caption, class, rows, where, group, after, end", key));
    }
  }

  void take_column(const std::vector<std::string>& fields) {
    if (form_.blocks.empty()) fail("a column before \"rows\"");
    if (fields.size() < 3 || fields.size() > 4) fail("a column is \"title :: kind :: cell\", or \":: when\" behind it");
    Column column{fields[0], fields[2], fields.size() == 4 ? fields[3] : "", "", ""};
    std::string number, main, name, after;
    for (const std::string& word : words_of(fields[1])) {
      if (word == "heading") {
        column.heading = true;
      } else if (word == "once") {
        column.once = true;
      } else if (word == "number") {
        number = "num";
      } else if (word == "main") {
        main = " main";
      } else if (word == "name") {
        name = " name";
      } else if (word == "after") {
        after = " after";
      } else if (word != "text") {
        fail(fmt::format("\"{}\" is none of text, number, main, name, after, heading, once", word));
      }
    }
    column.classes = trimmed(number + main + name + after);
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
    std::vector<PageScope::Json> group;
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
      const std::string cell = trimmed(fill_template(column.cell, row)), classes = class_attribute(column.classes);
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
  std::vector<PageScope::Json> last_group_;
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
