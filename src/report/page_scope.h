#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "support/text_template.h"

namespace granuscope {

/// In what language numbers and words are written.
enum class Markup { html, markdown };

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
/// a text or a yes. It is not written for null, no, a count of 0, and what is empty. {{#change=longer_above}} asks
/// whether a text is that one.
///
/// The overlay is JSON of the same shape and is looked up first. Its texts and numbers are plain ones without a span,
/// its yes and no steer sections. An object with a "key" there stands for that place of summary.json, and with a "text"
/// is written so.
class PageScope : public TemplateScope {
 public:
  using Json = nlohmann::ordered_json;

  /// A place with nothing around it. Both documents must outlive the scope.
  PageScope(const Json& summary, const Json& overlay, Markup markup);

  /// A place of the whole file `root`, by its pointer, with an overlay of its own.
  PageScope(const PageScope& root, const std::string& pointer, const Json& overlay);

  std::string text(const std::string& name) const override;
  std::string raw_text(const std::string& name) const override;
  void enter(const std::string& name, Missing missing, const Write& write) const override;
  /// A name that ends with ".table" is a table (report/page_table.h).
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
  const PageScope& root() const;

  Place here_;
  const PageScope* outer_ = nullptr;  ///< the place around this one
  Markup markup_;
};

}  // namespace granuscope
