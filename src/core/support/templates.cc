#include "support/templates.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <vector>

#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
/// A piece of a template: text between tags, or a tag with what it holds.
struct Piece {
  enum class Kind { text, name, raw_name, section, inverted, part };
  Kind kind = Kind::text;
  std::string content;  ///< the text, or the tag's name
  TemplateScope::Missing missing = TemplateScope::Missing::is_an_error;
  std::vector<Piece> inside = {};
};

class TemplateReader {
 public:
  explicit TemplateReader(std::string_view text) : text_(text) {}

  std::vector<Piece> read() {
    std::vector<Piece> pieces = read_until("");
    if (!closed_.empty()) throw std::logic_error(fmt::format("template: {{{{/{}}}}} closes nothing", closed_));
    return pieces;
  }

 private:
  static constexpr int most_levels = 100;

  /// Pieces up to the end or a closing tag, whose name is left in closed_.
  std::vector<Piece> read_until(const std::string& section) {
    std::vector<Piece> pieces;
    while (at_ < text_.size()) {
      const std::size_t start = text_.find("{{", at_);
      if (start != at_) pieces.push_back({Piece::Kind::text, std::string(text_.substr(at_, start - at_))});
      if (start == std::string_view::npos) {
        at_ = text_.size();
        break;
      }
      const bool raw = text_.substr(start).starts_with("{{{");
      const std::string_view closing = raw ? "}}}" : "}}";
      const std::size_t end = text_.find(closing, start);
      if (end == std::string_view::npos) {
        throw std::logic_error(fmt::format("template: {}... is not closed", text_.substr(start, 30)));
      }
      std::string name(trimmed(text_.substr(start + closing.size(), end - start - closing.size())));
      at_ = end + closing.size();
      const char kind = raw || name.empty() ? ' ' : name.front();
      if (std::string_view("#^/>!").find(kind) == std::string_view::npos) {
        pieces.push_back({raw ? Piece::Kind::raw_name : Piece::Kind::name, name});
        continue;
      }
      const bool line_starts_here = start == 0 || text_[start - 1] == '\n';
      if (line_starts_here && at_ < text_.size() && text_[at_] == '\n') ++at_;
      name = trimmed(name.substr(1));
      if (kind == '/') {
        closed_ = name;
        return pieces;
      }
      if (kind == '>') pieces.push_back({Piece::Kind::part, name});
      if (kind == '#' || kind == '^') pieces.push_back(section_of(name, kind));
    }
    if (!section.empty()) throw std::logic_error(fmt::format("template: section {} is not closed", section));
    return pieces;
  }

  Piece section_of(std::string name, char kind) {
    Piece piece{kind == '#' ? Piece::Kind::section : Piece::Kind::inverted, ""};
    if (name.ends_with('?')) {
      name.pop_back();
      piece.missing = TemplateScope::Missing::means_not_there;
    }
    piece.content = name;
    if (++level_ > most_levels) throw std::logic_error(fmt::format("template: sections nest {} deep", most_levels));
    piece.inside = read_until(name);
    --level_;
    if (closed_ != name) {
      throw std::logic_error(fmt::format("template: section {} is closed by {{{{/{}}}}}", name, closed_));
    }
    closed_.clear();
    return piece;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int level_ = 0;
  std::string closed_;
};

void pass_over(const std::vector<Piece>& pieces, const TemplateScope& scope) {
  for (const Piece& piece : pieces) {
    if (piece.kind != Piece::Kind::text && piece.kind != Piece::Kind::part) scope.pass_over(piece.content);
    pass_over(piece.inside, scope);
  }
}

void write(const std::vector<Piece>& pieces, const TemplateScope& scope, std::string& filled) {
  for (const Piece& piece : pieces) {
    switch (piece.kind) {
      case Piece::Kind::text:
        filled += piece.content;
        break;
      case Piece::Kind::name:
        filled += scope.text(piece.content);
        break;
      case Piece::Kind::raw_name:
        filled += scope.raw_text(piece.content);
        break;
      case Piece::Kind::part:
        filled += scope.part(piece.content);
        break;
      case Piece::Kind::section:
      case Piece::Kind::inverted: {
        const bool upright = piece.kind == Piece::Kind::section;
        bool there = false;
        scope.enter(piece.content, piece.missing, [&](const TemplateScope& inside) {
          there = true;
          if (upright) write(piece.inside, inside, filled);
        });
        if (!upright && !there) write(piece.inside, scope, filled);
        if (upright != there) pass_over(piece.inside, scope);
      }
    }
  }
}

}  // namespace

std::string TemplateScope::part(const std::string& name) const { return fill_template_file(name, *this); }

void TemplateScope::pass_over(const std::string& /*name*/) const {}

std::string fill_template(std::string_view text, const TemplateScope& scope) {
  std::string filled;
  write(TemplateReader(text).read(), scope, filled);
  return filled;
}

std::string fill_template_file(const std::string& name, const TemplateScope& scope) {
  constexpr int most_parts = 30;
  static thread_local int parts = 0;  // one in another: a file that is a part of itself has no end
  struct Level {
    Level() { ++parts; }
    ~Level() { --parts; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;
  } const level;
  if (parts > most_parts) throw std::logic_error(fmt::format("it is the {}th part within a part", most_parts));
  const std::string_view text = template_file(name);
  try {
    return fill_template(text, scope);
  } catch (const std::logic_error& error) {
    throw std::logic_error(fmt::format("templates/{}: {}", name, error.what()));
  }
}

namespace {

struct StandIns {
  fs::path folder;
  std::map<std::string, std::string, std::less<>> files;
};

StandIns& stand_ins() {
  static StandIns instance;
  return instance;
}

const EmbeddedFile* find_embedded(std::string_view name) {
  const std::span<const EmbeddedFile> files = embedded_files();
  const auto found =
      std::lower_bound(files.begin(), files.end(), name,
                       [](const EmbeddedFile& file, std::string_view wanted) { return file.name < wanted; });
  return found == files.end() || found->name != name ? nullptr : &*found;
}

/// Whether it is the script of a figure, which has captions.
bool is_script_of_figure(std::string_view name) {
  constexpr std::string_view end = ".gp.mustache";
  return name.ends_with(end) &&
         find_embedded(std::string(name.substr(0, name.size() - end.size())) + ".captions") != nullptr;
}

}  // namespace

bool has_template(std::string_view name) { return stand_ins().files.contains(name) || find_embedded(name) != nullptr; }

std::string_view template_file(std::string_view name) {
  const auto& others = stand_ins().files;
  if (const auto other = others.find(name); other != others.end()) return other->second;
  const EmbeddedFile* file = find_embedded(name);
  if (file == nullptr) throw std::logic_error(fmt::format("no file templates/{} was built into the program", name));
  return file->content;
}

std::string name_in_language(const std::string& name, const std::string& language) {
  const std::string other = language + "/" + name;
  return stand_ins().files.contains(name) || find_embedded(other) == nullptr ? name : other;
}

void use_templates(const fs::path& folder) {
  StandIns given;
  given.folder = folder;
  std::error_code error;
  if (!folder.empty() && !fs::is_directory(folder, error)) {
    throw InputError(
        "{}: there is no such folder to take templates from; name one that holds files as templates/ of the project "
        "does",
        folder.string());
  }
  auto at = folder.empty() ? fs::recursive_directory_iterator() : fs::recursive_directory_iterator(folder, error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    const std::string name = at->path().lexically_relative(folder).generic_string();
    if (!at->is_regular_file(error) || at->path().filename().string().starts_with('.')) continue;
    if (find_embedded(name) == nullptr && !is_script_of_figure(name)) {
      throw InputError(
          "{}: the program has no template {}, so that this file would change nothing; give it the path of one of "
          "templates/, or take it away",
          at->path().string(), name);
    }
    given.files.emplace(name, read_file(at->path()));
  }
  if (error) {
    throw InputError("{}: cannot be read ({}), and so no template there; correct its permissions", folder.string(),
                     error.message());
  }
  stand_ins() = std::move(given);
}

const fs::path& templates_folder() { return stand_ins().folder; }

std::string templates_digest() {
  std::string all;
  for (const auto& [name, content] : stand_ins().files) {
    all += fmt::format("{} {}\n", name, content.size());
    all += content;
  }
  return all.empty() ? "" : sha256(all);
}

}  // namespace granuscope
