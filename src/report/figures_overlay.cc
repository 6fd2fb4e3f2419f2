#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "report/data_uri.h"
#include "report/png_size.h"
#include "report/report_overlay.h"
#include "report/svg_for_weasyprint.h"
#include "support/atomic_file.h"
#include "support/error.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

constexpr double text_width_mm = 170;  // of print.css: A4 less two margins of 20 mm

/// Embeds the screen version in both media: a PDF cannot stand in a page, an SVG stays vector in print as well.
std::string embedded(const Figure& figure, const std::filesystem::path& run_folder, PageMedium medium) {
  const std::string extension = figure.screen.extension().string();
  const std::string bytes = read_file(run_folder / figure.screen);
  if (extension == ".png") return data_uri("image/png", bytes);
  if (extension == ".svg") {
    return data_uri("image/svg+xml", medium == PageMedium::print ? svg_for_weasyprint(bytes) : bytes);
  }
  throw InputError(fmt::format("figure {} is neither SVG nor PNG ({}), so the report cannot hold it; make it again",
                               figure.id, figure.screen.string()));
}

/// "figures/response-profiles.svg, .pdf, .gp, -layer-110.csv": the first name whole, of the others what differs; many
/// data files are only counted.
std::string files_in_words(const Figure& figure) {
  std::vector<std::filesystem::path> files = {figure.screen};
  if (figure.print != figure.screen) files.push_back(figure.print);
  if (!figure.script.empty()) files.push_back(figure.script);
  const bool many = figure.data.size() > 4;
  if (!many) files.insert(files.end(), figure.data.begin(), figure.data.end());
  const std::string stem = (figure.screen.parent_path() / figure.screen.stem()).generic_string();
  std::string words = files.front().generic_string();
  for (std::size_t i = 1; i < files.size(); ++i) {
    const std::string name = files[i].generic_string();
    words += ", " + (name.starts_with(stem) ? name.substr(stem.size()) : name);
  }
  if (many) words += fmt::format(", -*.csv ({} files)", figure.data.size());
  return words;
}

/// Messages end with a full stop or without.
std::string as_sentence(const std::string& message) {
  return message.empty() || message.ends_with('.') ? message : message + '.';
}

}  // namespace

void add_figures(Json& overlay, const ReportData& data, const std::filesystem::path& run_folder, PageMedium medium) {
  Json rows = Json::array();
  for (const Figure& figure : data.figures) {
    const bool raster = figure.screen.extension() == ".png";
    const std::optional<double> width =
        raster && medium == PageMedium::print ? png_width_mm(read_file(run_folder / figure.screen)) : std::nullopt;
    rows.push_back({{"number", rows.size() + 1},
                    {"is_there", figure.is_there()},
                    {"failure", as_sentence(figure.failure)},
                    {"image", figure.is_there() ? embedded(figure, run_folder, medium) : ""},
                    {"raster", raster},
                    {"width_mm", width ? fmt::format("{:.2f}", std::min(*width, text_width_mm)) : ""},
                    {"alternative", figure.alternative},
                    {"paper_says", figure.paper_says},
                    {"redraw", figure.redraw},
                    {"files", figure.is_there() ? files_in_words(figure) : ""}});
  }
  overlay["has_figures"] = !rows.empty();
  overlay["figures"] = rows;
}

}  // namespace granuscope
