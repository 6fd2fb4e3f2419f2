#pragma once
#include <functional>
#include <string>
#include <string_view>

namespace granuscope {

/// What the tags of a template stand for, at one place of it. Every function throws std::logic_error for a name it has
/// nothing for: a place that silently stays empty would be a wrong page or figure.
class TemplateScope {
 public:
  virtual ~TemplateScope() = default;

  /// Of {{name}}: escaped by the rule of what is written.
  virtual std::string text(const std::string& name) const = 0;

  /// Of {{{name}}}: as it stands.
  virtual std::string raw_text(const std::string& name) const = 0;

  enum class Missing { is_an_error, means_not_there };

  using Write = std::function<void(const TemplateScope&)>;
  /// Of {{#name}}: calls `write` with each scope in which the inside of the section is to be written, in order; never
  /// where nothing is there. `missing`: what to do if the name is not known at all; {{#name?}} asks for not_there.
  virtual void enter(const std::string& name, Missing missing, const Write& write) const = 0;

  /// Of {{> name}}: the file of that name, filled in here, unless another kind of scope makes something else of it.
  virtual std::string part(const std::string& name) const;

  /// A tag inside of a section that is not written. To know what a template asks for in all.
  virtual void pass_over(const std::string& name) const;
};

/// Fills in a template. Mustache's tags: {{name}}, {{{name}}}, {{#name}}...{{/name}}, {{^name}}...{{/name}} (written
/// where the section is not), {{> part}}, {{! comment}}. {{#name?}} may be missing altogether; {{/name}} closes it. A
/// tag of a section, a part or a comment alone on its line leaves no empty line. What is filled in is never read as a
/// template again. Throws std::logic_error for a tag that is not closed, naming it.
std::string fill_template(std::string_view text, const TemplateScope& scope);

/// fill_template with the file templates/<name>; what is thrown names the file.
std::string fill_template_file(const std::string& name, const TemplateScope& scope);

}  // namespace granuscope
