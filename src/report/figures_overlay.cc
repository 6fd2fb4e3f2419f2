#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "report/data_uri.h"
#include "report/png_size.h"
#include "report/report_overlay.h"
#include "report/svg_for_weasyprint.h"
#include "support/atomic_file.h"
#include "support/clean_text.h"
#include "support/error.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

constexpr double text_width_mm = 170;  // of print.css: A4 less two margins of 20 mm
constexpr double half_width_mm = 85;   // two narrower ones stand side by side

/// Of an SVG in pixels of 1/96 inch.
double svg_width_mm(const std::string& svg) {
  static constexpr std::string_view attribute = "width=\"";
  const std::size_t at = svg.find(attribute, svg.find("<svg"));
  if (at == std::string::npos) return text_width_mm;
  return std::strtod(svg.c_str() + at + attribute.size(), nullptr) / 96 * 25.4;
}

bool has_half_width(const Figure& figure, const std::filesystem::path& run_folder) {
  if (figure.screen.extension() == ".png") return true;
  return figure.is_there() && svg_width_mm(read_file(run_folder / figure.screen)) < half_width_mm;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// The image of a file: SVG in both media, since a PDF cannot stand in a page, and an SVG stays vector in print as
/// well.
std::string embedded(const Figure& figure, const std::filesystem::path& image, const std::filesystem::path& run_folder,
                     PageMedium medium) {
  const std::string extension = image.extension().string();
  const std::string bytes = read_file(run_folder / image);
  if (extension == ".png") return data_uri("image/png", bytes);
  if (extension == ".svg") {
    return data_uri("image/svg+xml", medium == PageMedium::print ? svg_for_weasyprint(bytes) : bytes);
  }
  throw InputError(fmt::format("figure {} is neither SVG nor PNG ({}), so the report cannot hold it; make it again",
                               figure.id, image.string()));
}

constexpr std::size_t most_embedded = 100'000;  ///< bytes of data files of one figure

std::string link(const std::string& to, const std::string& file_name, const std::string& text) {
  return fmt::format("<a href=\"{}\" download=\"{}\">{}</a>", escape_markup(to), escape_markup(file_name),
                     escape_markup(text));
}

/// Links to the figure's files beside the page. The data stand in the page itself, as long as they are short, so that
/// they come along where it is sent alone. On paper only the names.
std::string links_to_files(const Figure& figure, const std::filesystem::path& run_folder, PageMedium medium) {
  const std::string stem = figure.screen.stem().generic_string();
  if (medium == PageMedium::print) return fmt::format("Files: figures/{}.*.", escape_markup(stem));
  std::vector<std::pair<std::string, std::filesystem::path>> files = {{"", figure.screen}};
  if (figure.print != figure.screen) files.emplace_back("", figure.print);
  if (!figure.script.empty()) files.emplace_back("", figure.script);
  std::string links;
  for (const auto& [unused, file] : files) {
    const std::string kind = file.extension().string();
    links += link(file.generic_string(), file.filename().string(), kind == ".gp" ? "gnuplot" : upper(kind.substr(1))) +
             " · ";
  }
  std::size_t embedded = 0;
  std::string data;
  for (const std::filesystem::path& file : figure.data) {
    const std::string name = file.filename().string();
    const std::string bytes = std::filesystem::exists(run_folder / file) ? read_file(run_folder / file) : "";
    embedded += bytes.size();
    const bool inside = !bytes.empty() && embedded <= most_embedded;
    const std::string shown = name.starts_with(stem + "-") ? name.substr(stem.size() + 1) : name;
    data += link(inside ? data_uri("text/csv", bytes) : file.generic_string(), name, shown) + " ";
  }
  if (figure.data.empty() || figure.data.size() > 2) links.erase(links.size() - std::string_view(" · ").size());
  if (figure.data.size() > 2) {
    data = fmt::format("<details><summary>{} data files</summary>{}</details>", figure.data.size(), data);
  }
  return links + data;
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
    const std::optional<double> width = raster ? png_width_mm(read_file(run_folder / figure.screen)) : std::nullopt;
    rows.push_back(
        {{"number", rows.size() + 1},
         {"on_page_1", figure.id == data.key_figure},
         {"is_there", figure.is_there()},
         {"failure", as_sentence(figure.failure)},
         {"image", figure.is_there() ? embedded(figure, figure.screen, run_folder, medium) : ""},
         {"narrow", !figure.narrow.empty() && medium == PageMedium::screen
                        ? embedded(figure, figure.narrow, run_folder, medium)
                        : ""},
         {"raster", raster},
         {"half", has_half_width(figure, run_folder)},
         // The picture alone, to be looked at closely; a link keeps what scrolls within reach of the keyboard.
         {"file", figure.is_there() && medium == PageMedium::screen ? figure.screen.generic_string() : ""},
         {"width_mm", width ? fmt::format("{:.2f}", std::min(*width, text_width_mm)) : ""},
         {"alternative", figure.alternative},
         {"paper_says", figure.paper_says},
         {"redraw", figure.redraw},
         {"links", figure.is_there() ? links_to_files(figure, run_folder, medium) : ""}});
  }
  overlay["has_figures"] = !rows.empty();
  overlay["figures"] = rows;
}

}  // namespace granuscope
