#include "plot/plot_script.h"

#include <fmt/format.h>

#include "plot/plot_colours.h"
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

}  // namespace

std::string fill_script_part(const std::string& name, TemplateVariables variables) {
  const std::string part = plot_template(name);
  add_colours_used(variables, part);
  return fill_template(part, variables);
}

Figure plot_figure(const PlotPlan& plan, const TemplateVariables& variables, const std::filesystem::path& run_folder) {
  const std::string script_template = plot_template(plan.script);
  const std::string height = exact(plan.height);
  TemplateVariables all = variables;
  all["stem"] = plan.id;
  all["begin_pass"] = fill_template(plot_template("plot/begin_pass"),
                                    {{"stem", plan.id}, {"width", exact(plot_width_inches)}, {"height", height}});
  all["key_panel"] = plot_template("plot/key_panel");
  all["end_of_pass"] = plot_template("plot/end_of_pass");
  add_colours_used(all, script_template);

  GnuplotJob job;
  job.stem = plan.id;
  job.script = fill_template(script_template, all);
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
