#include "plot/figure_captions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>
#include <stdexcept>

#include "plot/plot_texts.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {
namespace {

constexpr std::string_view mu_equals = "μ = ";

std::map<std::string, std::string> paragraphs_by_heading(const std::string& text) {
  std::map<std::string, std::string> paragraphs;
  std::string heading;
  std::stringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() > 2 && line.front() == '[' && line.back() == ']') {
      heading = line.substr(1, line.size() - 2);
      continue;
    }
    std::stringstream words(line);
    for (std::string word; words >> word;) {
      std::string& paragraph = paragraphs[heading];
      if (!paragraph.empty()) paragraph += ' ';
      paragraph += word;
    }
  }
  return paragraphs;
}

}  // namespace

void set_captions(Figure& figure, const Wording& wording, std::string_view catalogue) {
  const auto paragraphs = paragraphs_by_heading(
      fill_template(template_file(wording.captions),
                    in_words_of(wording.variables, catalogue.empty() ? template_file("plot/labels.txt") : catalogue)));
  const auto paragraph = [&](const std::string& heading) {
    const auto found = paragraphs.find(heading);
    if (found == paragraphs.end()) throw std::logic_error(wording.captions + " lacks [" + heading + "]");
    return found->second;
  };
  figure.title = in_terms(paragraph("title"), wording.terms);
  figure.caption = in_terms(paragraph("caption"), wording.terms);
  figure.details = in_terms(paragraph("details"), wording.terms);
  figure.alternative = in_terms(paragraph("alternative"), wording.terms);
  figure.paper_says = paragraph("paper_says");
}

std::string enumeration(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 == items.size() ? " and " : ", ";
    text += items[i];
  }
  return text;
}

std::string with_reasons(const std::vector<LeftOut>& items) {
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;
  for (const LeftOut& item : items) {
    auto group = std::ranges::find_if(groups, [&item](const auto& known) { return known.first == item.why; });
    if (group == groups.end()) group = groups.insert(groups.end(), {item.why, {}});
    const bool repeated = !group->second.empty() && group->second.front().starts_with(mu_equals);
    group->second.push_back(repeated && item.what.starts_with(mu_equals) ? item.what.substr(mu_equals.size())
                                                                         : item.what);
  }
  std::vector<std::string> texts;
  texts.reserve(groups.size());
  for (const auto& [why, whats] : groups) texts.push_back(fmt::format("{} ({})", enumeration(whats), why));
  return enumeration(texts);
}

std::string count_in_words(std::size_t count) {
  constexpr std::array words = {"no",    "one",   "two",  "three", "four",   "five",  "six",
                                "seven", "eight", "nine", "ten",   "eleven", "twelve"};
  return count < words.size() ? words[count] : std::to_string(count);
}

std::string caption_number(double value, int digits) {
  std::string text = fmt::format("{:.{}g}", value, digits);
  if (text.find('e') != std::string::npos) return significant(value, digits);
  if (text.front() == '-') text.replace(0, 1, "−");
  return text;
}

std::string in_words(const ResponseSpec& response) {
  std::string name = name_of(response.estimator);
  if (response.estimator != EstimatorName::multiplexed) return name + (response.coupled ? ", coupled" : "");
  return fmt::format("{}, ε = {}{}{}", name, caption_number(response.epsilon), response.opposite ? ", opposite" : "",
                     response.sign_run > 1 ? fmt::format(", runs of {}", response.sign_run) : "");
}

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
