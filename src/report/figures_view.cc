#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/data_uri.h"
#include "report/report_view.h"
#include "report/svg_for_weasyprint.h"
#include "support/atomic_file.h"
#include "support/error.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// Embeds the screen version in both media: a PDF cannot stand in a page, an SVG stays vector in print as well.
std::string embedded(const Figure& figure, const std::filesystem::path& run_folder, PageMedium medium) {
  const std::string extension = figure.screen.extension().string();
  const std::string bytes = read_file(run_folder / figure.screen);
  if (extension == ".png") return data_uri("image/png", bytes);
  if (extension == ".svg") {
    return data_uri("image/svg+xml", medium == PageMedium::print ? svg_for_weasyprint(bytes) : bytes);
  }
  throw InputError(fmt::format("figure {} is neither SVG nor PNG ({}), so the report cannot hold it; draw it again",
                               figure.id, figure.screen.string()));
}

}  // namespace

Json figures_view(const ReportData& data, const std::filesystem::path& run_folder, PageMedium medium) {
  Json figures = Json::array();
  for (std::size_t i = 0; i < data.figures.size(); ++i) {
    const Figure& figure = data.figures[i];
    Json view;
    view["number"] = std::to_string(i + 1);
    view["anchor"] = fmt::format("figure-{}", i + 1);
    view["figure_title"] = figure.title;
    view["image"] = embedded(figure, run_folder, medium);
    view["alternative"] = figure.alternative;
    view["caption_key"] = fmt::format("/figures/{}/caption", i);
    view["caption"] = figure.caption;
    view["paper_says"] = figure.paper_says;
    view["has_paper_says"] = !figure.paper_says.empty();
    view["redraw"] = figure.redraw;
    view["files"] = Json::array();
    std::vector<std::filesystem::path> files = {figure.screen};
    if (figure.print != figure.screen) files.push_back(figure.print);
    if (!figure.script.empty()) files.push_back(figure.script);
    files.insert(files.end(), figure.data.begin(), figure.data.end());
    for (const std::filesystem::path& file : files) view["files"].push_back(file.generic_string());
    figures.push_back(view);
  }
  return figures;
}

}  // namespace granuscope
