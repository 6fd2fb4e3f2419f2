#include "plot/plot_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "plot/plot_colours.h"
#include "plot/plot_language.h"
#include "support/error.h"
#include "support/number_format.h"
#include "support/provenance.h"
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

std::string part_place(std::size_t index) { return fmt::format("<part {}>", index); }

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

std::string PlotPlan::add_part(ScriptPart part) {
  parts.push_back(std::move(part));
  return part_place(parts.size() - 1);
}

std::string fill_script(const FigureRecipe& recipe) {
  const std::string script_template = plot_template(recipe.script);
  TemplateVariables all = recipe.variables;
  all["stem"] = recipe.id;
  all["begin_pass"] = begin_pass_place;
  if (script_template.find("{{key_panel}}") != std::string::npos) all["key_panel"] = plot_template("plot/key_panel");
  all["end_of_pass"] = plot_template("plot/end_of_pass");
  add_colours_used(all, script_template);
  std::string script = fill_template(script_template, all);
  for (std::size_t i = 0; i < recipe.parts.size(); ++i) {
    const std::string place = part_place(i), part_template = plot_template(recipe.parts[i].script);
    const std::size_t at = script.find(place);
    if (at == std::string::npos) continue;
    TemplateVariables variables = recipe.parts[i].variables;
    add_colours_used(variables, part_template);
    script.replace(at, place.size(), fill_template(part_template, variables));
  }
  script = in_language(in_language(script, recipe.wording.terms), template_file("plot/labels.txt"));
  const KeySize key = size_of_key(script);
  return script.replace(
      script.find(begin_pass_place), std::string_view(begin_pass_place).size(),
      fill_template(plot_template("plot/begin_pass"),
                    {{"stem", recipe.id},
                     {"width", exact(plot_width_inches)},
                     {"height", exact(recipe.height)},
                     {"own_width", exact(recipe.half_width ? half_plot_width_inches : plot_width_inches)},
                     {"own_points", recipe.half_width ? "8" : "9"},
                     {"key_entries", std::to_string(key.entries)},
                     {"key_letters", std::to_string(key.letters)}}));
}

Figure plot_figure(const PlotPlan& plan, const TemplateVariables& variables, const Wording& wording,
                   const std::filesystem::path& run_folder) {
  const std::filesystem::path folder = "figures";
  Figure figure;
  figure.id = plan.id;
  figure.redraw = fmt::format("cd figures && gnuplot -d {}.gp", plan.id);
  set_captions(figure, wording);

  const FigureRecipe recipe{plan.id,    plan.script, plan.height,  plan.half_width, variables,
                            plan.parts, wording,     figure.title, figure.caption,  plot_colours()};
  GnuplotJob job;
  job.stem = plan.id;
  job.script = fill_script(recipe);
  job.data = plan.data;
  for (auto& [name, csv] : job.data) {
    const std::size_t head = std::min(csv.find('\n'), csv.size());
    csv = in_terms(csv.substr(0, head), wording.terms) + csv.substr(head);
  }
  job.recipe = recipe_json(recipe);
  job.label = FileLabel{figure.title, figure.redraw, provenance_line(collect_provenance())};
  job.curves = plan.curves;
  job.narrow_inches = plan.half_width ? 0 : narrow_plot_width_inches;
  try {
    plot_with_gnuplot(job, run_folder / folder);
  } catch (const EnvironmentError& failure) {
    figure.failure = failure.what();
    if (!is_drawn(job, run_folder / folder)) return figure;
  }
  figure.screen = folder / (plan.id + ".svg");
  if (job.narrow_inches > 0) figure.narrow = folder / narrow_svg(plan.id);
  figure.print = folder / (plan.id + ".pdf");
  figure.script = folder / (plan.id + ".gp");
  figure.recipe = folder / (plan.id + ".json");
  for (const auto& [name, csv] : plan.data) figure.data.push_back(folder / name);
  return figure;
}

}  // namespace granuscope
