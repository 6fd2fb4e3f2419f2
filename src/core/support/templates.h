#pragma once
#include <filesystem>
#include <functional>
#include <span>
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

/// A file of templates/, or an experiment of examples/, as it was when the program was built.
struct EmbeddedFile {
  /// Path below templates/, with forward slashes ("palette.txt", "plot/response.gp"), or "examples/quick.toml".
  std::string_view name;
  std::string_view content;  ///< every byte of it; valid as long as the program runs
};

/// Every file below templates/ and the experiments of examples/, sorted by name. They are compiled into the program
/// (cmake/embed.cmake), which therefore works without being installed.
std::span<const EmbeddedFile> embedded_files();

/// The content of templates/<name>, or of the file that use_templates put in its place. Throws std::logic_error if
/// there is no such file: names of templates come from the program, not from the user.
std::string_view template_file(std::string_view name);

/// Whether template_file has it.
bool has_template(std::string_view name);

/// The name under which template_file has a text in this language: `name` where use_templates replaced it, else that of
/// templates/<language>/, else `name`.
std::string name_in_language(const std::string& name, const std::string& language);

/// From now on the files below `folder` stand in for the built-in ones of the same name: an author's wording, language
/// or colours. A script X.gp.mustache beside the captions X.captions of a figure stands in for the common one. An empty
/// path takes them back. To be called before any other thread asks for a template. Throws InputError if the folder
/// cannot be read or holds a file that stands in for none.
void use_templates(const std::filesystem::path& folder);

/// The folder of use_templates; empty if there is none.
const std::filesystem::path& templates_folder();

/// A digest of all files of use_templates with their names, to be part of what decides whether pages and figures that
/// are there already are still those asked for; "" if there are none.
std::string templates_digest();

}  // namespace granuscope
