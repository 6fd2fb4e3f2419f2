#include "plot/template_variables.h"

#include <fmt/format.h>

#include <set>
#include <stdexcept>

#include "support/text_template.h"

namespace granuscope {

namespace {

class VariableScope : public TemplateScope {
 public:
  explicit VariableScope(const TemplateVariables& variables) : variables_(variables) {}

  std::string raw_text(const std::string& name) const override {
    const auto found = variables_.find(name);
    if (found == variables_.end()) throw std::logic_error(fmt::format("plot template: no text for {{{{{}}}}}", name));
    asked_.insert(name);
    return found->second;
  }

  std::string text(const std::string& name) const override { return raw_text(name); }

  void enter(const std::string& name, Missing missing, const Write& write) const override {
    if (missing == Missing::means_not_there && !variables_.contains(name)) return;
    if (!raw_text(name).empty()) write(*this);
  }

  void pass_over(const std::string& name) const override { raw_text(name); }

  void require_all_asked() const {
    for (const auto& [name, value] : variables_) {
      if (!asked_.contains(name)) throw std::logic_error(fmt::format("plot template: nothing asks for {}", name));
    }
  }

 private:
  const TemplateVariables& variables_;
  mutable std::set<std::string> asked_;
};

}  // namespace

std::string fill_template(std::string_view text, const TemplateVariables& variables) {
  const VariableScope scope(variables);
  std::string filled = fill_template(text, scope);
  scope.require_all_asked();
  return filled;
}

}  // namespace granuscope
