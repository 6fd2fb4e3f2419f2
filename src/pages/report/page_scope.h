#pragma once
#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <string_view>

#include "plot/figure_captions.h"
#include "support/templates.h"

namespace granuscope {
/// In what language numbers and words are written; plain: for a terminal.
enum class Markup { html, markdown, tex, plain };

/// Text as TeX (inputenc, utf8) sets it as it stands; signs that it has not are question marks.
std::string escape_tex(std::string_view text);

/// Names in the report's templates: a place in summary.json, and beside it what is said there but does not stand in
/// that file.
///
/// A name is a JSON pointer from here without its first slash: {{mu}}, {{window_layers/0}}; "." is this place, "../mu"
/// a name one section further out, "$/seed" one of the whole file. {{c}} becomes <span
/// data-key="/results/0/c">0.5605(4)
/// </span>: an estimate with its error, an integer or a text as it stands, another number with at most four significant
/// digits, null as n/a. Formats stand behind bars: {{c|plain}} never with a power of ten; {{z|fixed 2}} so many digits
/// behind the point, {{residual|significant 2}} in all; {{claim|formulae}} with no formula broken over lines and
/// {{redraw|words}} with no word; {{id|class id}} with a class for the span; {{law|bare}} without it; {{c|key}} the
/// pointer alone. {{{c}}} is the bare text, not escaped.
///
/// A section is written for each element of a list, in it; once in an object; once, at the same place, for a number,
/// a text or a yes. It is not written for null, no, a count of 0, and what is empty.
///
/// A condition is written once, at the same place, or not: {{#change=longer_above}} where a text is that one,
/// {{#change!=longer_above}} where it is another, {{#sign_run>1}} and {{#mu<0.3}} where a number is larger or smaller,
/// {{#known c D}} where all these numbers are known, {{#any failures}} where a list is not empty, and {{#any variations
/// known c D}} where any of these numbers is known in any of its elements.
///
/// The overlay is JSON of the same shape and is looked up first. Its texts and numbers are plain ones without a span,
/// its yes and no steer sections. An object with a "key" there stands for that place of summary.json, and with a "text"
/// is written so.
class PageScope : public TemplateScope {
 public:
  /// A place with nothing around it. Both documents must outlive the scope.
  PageScope(const Json& summary, const Json& overlay, Markup markup);

  /// A place of the whole file `root`, by its pointer, with an overlay of its own.
  PageScope(const PageScope& root, const std::string& pointer, const Json& overlay);

  std::string text(const std::string& name) const override;
  std::string raw_text(const std::string& name) const override;
  void enter(const std::string& name, Missing missing, const Write& write) const override;
  /// A name that ends with ".table" is a table (report/page_scope.h).
  std::string part(const std::string& name) const override;

  /// Whether a section of that name would be written; "^name": would not be.
  bool has(const std::string& name) const;

  /// The value itself, to be compared with others.
  const Json& value(const std::string& name) const;

 private:
  /// What stands under one name: in summary.json, in the overlay, or in both.
  struct Place {
    std::string pointer;
    const Json* summary = nullptr;
    const Json* overlay = nullptr;

    /// Whether it is the overlay that says what stands here, and not only something beside it.
    bool is_overlaid() const;
  };

  PageScope(const PageScope& outer, const Place& place);
  Place look_up(const std::string& name) const;
  Place known(const std::string& name) const;
  Place element(const Place& list, std::size_t i) const;
  /// Whether what `name` says holds; nothing if it is no condition.
  std::optional<bool> condition(const std::string& name, Missing missing) const;
  const PageScope& root() const;

  Place here_;
  const PageScope* outer_ = nullptr;  ///< the place around this one
  Markup markup_;
};

/// Where an estimate is unknown, the reason as a note below the table. `place`: where among the numbers of that name,
/// as " at μ = 0.1"; those with the same reason share a note, in it those with the same place their place.
void add_reason(Json& notes, const Json& summary, const std::string& pointer, const std::string& name,
                const std::string& place);

/// The name of what a run has scanned; of runs from before there was another, mu.
std::string scanned_in(const Json& summary);
/// Where what was scanned stands in a result: "/results/0/mu".
std::string place_of_scanned(const Json& summary, std::size_t result);
/// "μ = 0.1" of a result.
std::string at_scanned(const Json& summary, std::size_t result);

/// Puts what each note is about into words: "c at μ = 0.1; c and D at μ = 0.6". Each note then has "what", "are" ("is"
/// or "are") and the cell "reason".
void finish_notes(Json& notes);

/// The HTML of a table that templates/<file> describes, at a place of summary.json; nothing if it has no rows.
///
///     caption: Share of the beads that had to draw another number
///     class: redrawn
///     rows: piles
///     group: mu
///
///     <var>μ</var>    :: heading number :: {{mu}}
///     beads of a pile :: number         :: {{columns}} × {{layers}}
///     share           :: main number    :: {{share|plain}} :: some_share
///
/// Keys come first. caption: a template over the place where the table stands. class: of <table>, for the style sheets.
/// rows: a list, one row for each element; "results > windows" is a list within each element of a list. where: only the
/// rows that have this ("^this": that have it not). group: a new block begins where one of these values changes. after:
/// HTML behind each row, over the row. end: HTML behind the last row, over the table's place. A line for each column
/// follows: title, kind, cell and, if only some tables have the column, what the table's place must have for it ("^":
/// must not have). Title and cell are HTML templates (report/page_scope.h), the cell over a row. Of the kind's words,
/// heading makes the cell the row's heading, once leaves it empty but in the first row of a block, and number, main,
/// name and after are for the style sheets. A second "rows:" begins a further block with columns and titles of its own.
///
/// A line that begins with a space goes on with the one before; # begins a comment. Throws std::logic_error with file
/// and line for what is not of this form.
std::string page_table(const std::string& file, const PageScope& place);

/// The same from the text of the file; `file` names it in messages.
std::string page_table(const std::string& file, std::string_view text, const PageScope& place);

}  // namespace granuscope
