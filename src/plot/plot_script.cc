#include "plot/plot_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "plot/plot_colours.h"
#include "plot/plot_language.h"
#include "support/error.h"
#include "support/number_format.h"
#include "support/template_file.h"

namespace granuscope {

namespace {

std::string plot_template(const std::string& name) {
  return std::string(template_file(fmt::format("{}.gp.mustache", name)));
}

/// Colours the script does not use are no mistake; every other variable must be asked for.
void add_colours_used(TemplateVariables& variables, const std::string& script) {
  for (const auto& [name, colour] : plot_colours()) {
    if (script.find("{{" + name + "}}") != std::string::npos) variables.emplace(name, colour);
  }
}

constexpr const char* begin_pass_place = "<begin_pass>";

}  // namespace

KeySize size_of_key(const std::string& script) {
  KeySize size;
  constexpr std::string_view entry = "keyentry ", title = " title '";
  for (std::size_t at = script.find(entry); at != std::string::npos; at = script.find(entry, at + 1)) {
    const std::size_t end = std::min(script.find(entry, at + 1), script.size());
    const std::size_t begins = script.find(title, at);
    if (begins >= end) continue;
    int letters = 0;
    for (std::size_t i = begins + title.size(); i < end; ++i) {
      if (script[i] == '\'' && script[++i] != '\'') break;                          // a doubled one is one of the text
      letters += (static_cast<unsigned char>(script[i]) & 0xC0U) != 0x80U ? 1 : 0;  // UTF-8
    }
    ++size.entries;
    size.letters = std::max(size.letters, letters);
  }
  return size;
}

std::string fill_script_part(const std::string& name, TemplateVariables variables) {
  const std::string part = plot_template(name);
  add_colours_used(variables, part);
  return fill_template(part, variables);
}

Figure plot_figure(const PlotPlan& plan, const TemplateVariables& variables, const std::filesystem::path& run_folder) {
  const std::string script_template = plot_template(plan.script);
  TemplateVariables all = variables;
  all["stem"] = plan.id;
  all["begin_pass"] = begin_pass_place;
  if (script_template.find("{{key_panel}}") != std::string::npos) all["key_panel"] = plot_template("plot/key_panel");
  all["end_of_pass"] = plot_template("plot/end_of_pass");
  add_colours_used(all, script_template);

  GnuplotJob job;
  job.stem = plan.id;
  job.script = fill_template(script_template, all);
  job.script = in_language(job.script, template_file("plot/labels.txt"));
  const KeySize key = size_of_key(job.script);
  job.script.replace(job.script.find(begin_pass_place), std::string_view(begin_pass_place).size(),
                     fill_template(plot_template("plot/begin_pass"), {{"stem", plan.id},
                                                                      {"width", exact(plot_width_inches)},
                                                                      {"height", exact(plan.height)},
                                                                      {"key_entries", std::to_string(key.entries)},
                                                                      {"key_letters", std::to_string(key.letters)}}));
  job.data = plan.data;
  job.curves = plan.curves;
  const std::filesystem::path folder = "figures";
  Figure figure;
  figure.id = plan.id;
  try {
    plot_with_gnuplot(job, run_folder / folder);
  } catch (const EnvironmentError& failure) {
    figure.failure = failure.what();
    if (!is_drawn(job, run_folder / folder)) return figure;
  }
  figure.screen = folder / (plan.id + ".svg");
  figure.print = folder / (plan.id + ".pdf");
  figure.script = folder / (plan.id + ".gp");
  for (const auto& [name, csv] : plan.data) figure.data.push_back(folder / name);
  figure.redraw = fmt::format("cd figures && gnuplot -d {}.gp", plan.id);
  return figure;
}

}  // namespace granuscope
