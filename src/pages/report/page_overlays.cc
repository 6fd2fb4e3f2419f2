#include "report/page_overlays.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "model/lattice.h"
#include "plot/figure_captions.h"
#include "plot/plot_texts.h"
#include "report/number_text.h"
#include "report/page_scope.h"
#include "report/pdf_report.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {
namespace {
/// The parts of one place, one after the other.
std::string written_parts(const std::vector<ReportPart>& parts, ReportPart::Place place, const PageScope& root) {
  std::string html;
  for (const ReportPart& part : parts) {
    const PageScope scope(root, part.base, part.overlay);
    if (part.place == place && scope.has(part.needs)) html += scope.part(part.page);
  }
  return html;
}

}  // namespace

std::vector<GlossaryEntry> glossary() {
  std::vector<GlossaryEntry> entries;
  std::istringstream lines{std::string(template_file("glossary.txt"))};
  bool on_page = true;
  for (std::string line; std::getline(lines, line);) {
    on_page = on_page && !(line.starts_with('#') && !entries.empty());
    const std::size_t equals = line.find(" = ");
    if (line.empty() || line.starts_with('#')) continue;
    if (equals == std::string::npos) {
      throw std::logic_error(fmt::format("templates/glossary.txt: '{}' does not read `word, another = text`", line));
    }
    entries.push_back({parts_between(line.substr(0, equals), ", "), line.substr(equals + 3), on_page});
  }
  return entries;
}

std::string report_page(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder,
                        PageMedium medium) {
  const bool print = medium == PageMedium::print;
  // A browser prints the page as WeasyPrint does.
  Json overlay = {{"screen_style", print ? "" : template_file("screen.css")},
                  {"print_style", template_file("print.css")},
                  {"print", print},
                  {"script", print ? "" : template_file("report.js")},
                  {"program", data.provenance.program_version},
                  {"title", title_of(data)},
                  {"description", data.description},
                  {"checks", data.checks},
                  {"skipped", data.skipped},
                  {"law_description", data.law_description},
                  {"other_laws", Json::array()}};
  for (const auto& [law, sentences] : data.other_law_descriptions) {
    overlay["other_laws"].push_back({{"law", law}, {"sentences", sentences}});
  }
  add_results(overlay, summary);
  add_headline(overlay, summary, data.headline);
  add_causes(overlay, summary);
  add_laws(overlay, summary);
  add_claims(overlay, summary);
  add_numerics(overlay, summary);
  add_figures(overlay, data, run_folder, medium);
  add_provenance(overlay, data);
  if (!print) add_explored_depths(overlay, data.analysis);

  overlay["words"] = Json::array();
  for (const GlossaryEntry& entry : glossary()) {
    if (!entry.on_page) continue;
    std::string anchor = entry.names.front();
    std::replace(anchor.begin(), anchor.end(), ' ', '-');
    overlay["words"].push_back(
        {{"anchor", anchor}, {"names", fmt::format("{}", fmt::join(entry.names, ", "))}, {"meaning", entry.text}});
  }

  const PageScope root(summary, overlay, Markup::html);
  // What the experiment is about has its own sentences on page 1; the experiment's own words come before all others.
  const std::string of_study = data.headline.empty() ? written_parts(data.parts, ReportPart::Place::page_1, root) : "";
  overlay["headline"]["of_study"] = of_study;
  if (!of_study.empty()) {
    overlay["has_headline"] = true;
    overlay["headline"]["generated"] = false;
    overlay["headline"]["scanned"] = nullptr;
    overlay["headline"]["nothing"] = nullptr;
  }
  overlay["numbers_parts"] = written_parts(data.parts, ReportPart::Place::numbers, root);
  overlay["numerics_parts"] = written_parts(data.parts, ReportPart::Place::numerics, root);
  return fill_template_file("report.html.mustache", root);
}

namespace {

/// A claim keeps its number and the standard error side by side; the page has them as any other number.
void add_measured(Json& row, const Json& claim, const std::string& pointer) {
  if (!claim.at("measured").is_number() || !claim.at("stderr").is_number()) return;
  const auto value = claim.at("measured").get<double>(), error = claim.at("stderr").get<double>();
  if (!(error > 0)) return;
  const bool no_power = claim.contains("power_law");  // as everywhere, without an error
  row["measured"] = {{"key", pointer + "/measured"},
                     {"text", no_power ? significant(value, 3) : plain_value_with_error(value, error)}};
  if (no_power) row["piles_alone"] = significant(error, 2);
}

constexpr double strip_reach = 10;  ///< pulls that the strip shows; beyond, an arrow at its end

/// The pull as a place on a strip, clipped with an arrow.
void add_pull(Json& row, const Json& claim) {
  if (!claim.at("z_score").is_number()) return;
  const double pull = claim.at("z_score").get<double>();
  row["pull"] = {{"at", fmt::format("{:.2f}", std::clamp(pull, -strip_reach, strip_reach))},
                 {"beyond_right", pull > strip_reach},
                 {"beyond_left", pull < -strip_reach},
                 {"inside", std::abs(pull) <= strip_reach}};
}

/// Error and tolerance of the paper's number together.
void add_allowed(Json& row, const Json& claim) {
  if (!claim.at("paper").is_number()) return;
  const double allowed = std::hypot(claim.at("paper_stderr").get<double>(), claim.at("tolerance").get<double>());
  if (allowed > 0) row["allowed"] = caption_number(allowed, 2);
}

}  // namespace

std::string look_of(const std::string& verdict) {
  return verdict == "reproduced"       ? "yes"
         : verdict == "not reproduced" ? "no"
         : verdict == "not tested"     ? "untested"
                                       : "open";
}

void add_claims(Json& overlay, const Json& summary) {
  Json rows = Json::array();
  bool any_beyond = false;
  std::map<std::string, int> counts;
  std::vector<std::string> untested;
  const Json& claims = summary.at("claims");
  // Misses first, then what is open; what was not tested last. Of each, the paper's claims come first.
  for (const auto& [look, own] : {std::pair<std::string, bool>{"no", false},
                                  {"no", true},
                                  {"open", false},
                                  {"open", true},
                                  {"yes", false},
                                  {"yes", true},
                                  {"untested", false},
                                  {"untested", true}}) {
    for (std::size_t i = 0; i < claims.size(); ++i) {
      const Json& claim = claims[i];
      const auto verdict = claim.at("verdict").get<std::string>();
      if (look_of(verdict) != look || claim.at("beyond_paper").get<bool>() != own) continue;
      const std::string pointer = fmt::format("/claims/{}", i);
      const Json& rival = claim.at("rival");
      Json row = {{"key", pointer},
                  {"look", look},
                  {"pull", nullptr},
                  {"allowed", ""},
                  {"piles_alone", ""},
                  {"rival_off", rival.is_object() && rival.at("distance").is_number()
                                    ? fmt::format("{:.1f}", std::abs(rival.at("distance").get<double>()))
                                    : ""},
                  {"excludes", rival.is_object() && claim.at("paper").is_null()},
                  {"differs", claim.at("expected").is_string() && claim.at("expected") != verdict}};
      add_measured(row, claim, pointer);
      add_pull(row, claim);
      add_allowed(row, claim);
      rows.push_back(row);
      any_beyond = any_beyond || (own && look != "untested");
      if (!own) ++counts[verdict];
      if (verdict == "not tested") untested.push_back(claim.at("id"));
    }
  }
  overlay["claim_counts"] = {{"reproduced", counts["reproduced"]},
                             {"not_reproduced", counts["not reproduced"]},
                             {"not_decided", counts["not decided"]},
                             {"not_tested", counts["not tested"]}};
  overlay["any_tested"] = untested.size() < claims.size();
  overlay["untested_list"] = fmt::format("{}", fmt::join(untested, ", "));
  overlay["any_beyond"] = any_beyond;
  overlay["claim_rows"] = rows;
}

namespace {

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
  if (!figure.is_there()) return figure.screen.extension() == ".png";
  if (figure.screen.extension() == ".png") {
    return png_width_mm(read_file(run_folder / figure.screen)).value_or(0) < half_width_mm;
  }
  return svg_width_mm(read_file(run_folder / figure.screen)) < half_width_mm;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// Each end of a line, with the blanks beside it, as one blank.
std::string on_one_line(std::string_view text) {
  std::string line;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_not_of(" \t\n", at), text.size());
    const std::string_view blanks = text.substr(at, end - at);
    line += blanks.find('\n') == std::string_view::npos ? blanks : std::string_view(" ");
    const std::size_t next = std::min(text.find_first_of(" \t\n", end), text.size());
    line += text.substr(end, next - end);
    at = next;
  }
  return line;
}

/// The image of a file: SVG in both media, since a PDF cannot stand in a page, and an SVG stays vector in print as
/// well.
std::string embedded(const Figure& figure, const std::filesystem::path& image, const std::filesystem::path& run_folder,
                     PageMedium medium) {
  const std::string extension = image.extension().string();
  const std::string bytes = read_file(run_folder / image);
  if (extension == ".png") return data_uri("image/png", bytes);
  if (extension == ".svg" && medium == PageMedium::print) return data_uri("image/svg+xml", svg_for_weasyprint(bytes));
  if (extension == ".svg") return text_uri("image/svg+xml", on_one_line(bytes));
  throw InputError("figure {} is neither SVG nor PNG ({}), so the report cannot hold it; make it again", figure.id,
                   image.string());
}

constexpr std::size_t most_embedded = 100'000;  ///< bytes of data files of one figure

std::string link(const std::string& to, const std::string& file_name, const std::string& text, const char* more = "") {
  return fmt::format("<a href=\"{}\" download=\"{}\"{}>{}</a>", escape_markup(to), escape_markup(file_name), more,
                     escape_markup(text));
}

/// Links to the figure's files beside the page. Script and data stand in the page itself, as long as they are short, so
/// that they come along where it is sent alone; so does the SVG, which its script takes from the picture. On paper only
/// the names.
std::string links_to_files(const Figure& figure, const std::filesystem::path& run_folder, PageMedium medium) {
  const std::string stem = figure.screen.stem().generic_string();
  if (medium == PageMedium::print) return fmt::format("Files: figures/{}.*.", escape_markup(stem));
  std::vector<std::pair<std::string, std::filesystem::path>> files = {{"", figure.screen}};
  if (figure.print != figure.screen) files.emplace_back("", figure.print);
  if (!figure.script.empty()) files.emplace_back("", figure.script);
  std::string links;
  for (const auto& [unused, file] : files) {
    const std::string kind = file.extension().string();
    const bool script = kind == ".gp" && std::filesystem::exists(run_folder / file);
    links += link(script ? text_uri("text/plain", read_file(run_folder / file)) : file.generic_string(),
                  file.filename().string(), kind == ".gp" ? "gnuplot" : upper(kind.substr(1)),
                  kind == ".svg" ? " data-plot" : "") +
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
    data += link(inside ? text_uri("text/csv", bytes) : file.generic_string(), name, shown) + " ";
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
  const auto word = [](const char* english) { return in_terms(english, template_file("plot/labels.txt")); };
  for (const Figure& figure : data.figures) {
    const bool raster = figure.screen.extension() == ".png";
    const std::optional<double> width = raster ? png_width_mm(read_file(run_folder / figure.screen)) : std::nullopt;
    rows.push_back(
        {{"number", rows.size() + 1},
         {"figure_word", word("Figure")},
         {"paper_word", word("The paper.")},
         {"made_word", word("How it is made")},
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
         {"touched", medium == PageMedium::screen ? figure.touched : ""},
         {"redraw", figure.redraw},
         {"links", figure.is_there() ? links_to_files(figure, run_folder, medium) : ""}});
  }
  // A narrow one without another beside it has its caption there.
  for (std::size_t i = 0, in_row = 0; i < rows.size(); ++i) {
    in_row = rows[i]["half"] == true ? in_row + 1 : 0;
    const bool last = i + 1 == rows.size() || rows[i + 1]["half"] == false;
    rows[i]["alone"] = in_row % 2 == 1 && last;
  }
  overlay["figures"] = rows;
}

namespace {

std::string verdict_of(const Json& summary, const char* id) {
  for (const Json& claim : summary.at("claims")) {
    if (claim.at("id") == id) return claim.at("verdict").get<std::string>();
  }
  return "not tested";
}

/// What the paper varies.
bool is_friction_of_beads(const Json& summary) {
  return scanned_in(summary) == "mu" && summary.at("scan").at("model") == "frictional-beads";
}

bool known(const Json& estimate) { return estimate.at("value").is_number(); }

}  // namespace

void add_causes(Json& overlay, const Json& summary) {
  const Json& scaling = summary.at("scaling");
  Json shifts = Json::array();
  // Whichever study holds the exponents of the paper's overload against those of the linear response.
  for (const auto& [id, study] : summary.at("studies").items()) {
    if (!study.is_object() || !study.contains("exponents")) continue;
    const Json& exponents = study.at("exponents");
    for (std::size_t i = 0; i < exponents.size(); ++i) {
      const Json& one = exponents[i];
      if (!one.is_object() || !one.contains("beta_minus_linear") || one.at("estimator") != "point" ||
          one.at("load") != 1 || !known(one.at("beta_minus_linear")) || !known(one.at("gamma_minus_linear"))) {
        continue;
      }
      shifts.push_back({{"key", fmt::format("/studies/{}/exponents/{}", id, i)}});
    }
  }
  bool moved = true;
  for (const char* name : {"beta", "gamma", "alpha"}) moved = moved && scaling.at(name).contains("systematic");
  overlay["overload_shift"] = shifts;
  const Json& studies = summary.at("studies");
  const bool literal = studies.contains("literal_reading") && studies.at("literal_reading").contains("best");
  overlay["read_literally"] = literal ? Json{{"key", "/studies/literal_reading"}} : Json(nullptr);
  overlay["depth_window"] = moved ? Json{{"key", "/scaling"}} : Json(nullptr);
  overlay["has_causes"] = is_friction_of_beads(summary) && known(scaling.at("gamma")) && known(scaling.at("alpha"));
}

/// c and D of one result, by their keys.
Json c_and_D_of(const Json& summary, std::size_t i) {
  const std::string place = fmt::format("/results/{}", i);
  Json one{{"scanned", {{"key", place_of_scanned(summary, i)}}},
           {"c", {{"key", place + "/c"}}},
           {"D", {{"key", place + "/D"}}}};
  if (is_rounding(summary.at("results")[i], "D")) one["D"]["text"] = "0";
  return one;
}

/// The result of the largest friction in the window of the exponents whose c and D are known; null if there is none.
Json at_end_of_window(const Json& summary) {
  const Json &results = summary.at("results"), &window = summary.at("scaling").at("gamma").at("window");
  Json last = nullptr;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Json& one = results[i];
    if (!known(one.at("c")) || !known(one.at("D")) || one.at("mu").get<double>() > window.at(1).get<double>()) continue;
    last = c_and_D_of(summary, i);
  }
  return last;
}

/// The first and the last result whose c and D are known, which may be one; null if there is none.
Json ends_of_scan(const Json& summary, bool powers, bool of_friction) {
  const Json& results = summary.at("results");
  std::vector<std::size_t> told;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (known(results[i].at("c")) && known(results[i].at("D"))) told.push_back(i);
  }
  if (told.empty()) return nullptr;
  const auto same = [&](const char* name) {  // within three errors of the first
    return std::ranges::all_of(told, [&](std::size_t i) {
      const auto number = [&](const Json& of, const char* what) {
        return of.at(name).at(what).is_number() ? of.at(name).at(what).get<double>() : HUGE_VAL;
      };
      const Json &one = results[i], &other = results[told.front()];
      return std::abs(number(one, "value") - number(other, "value")) <=
             3 * std::hypot(number(one, "stderr"), number(other, "stderr"));
    });
  };
  return {{"first", c_and_D_of(summary, told.front())},
          {"c_same", same("c")},
          {"D_same", same("D")},
          {"last", c_and_D_of(summary, told.back())},
          {"two", told.size() > 1},
          {"powers", powers},
          {"of_friction", of_friction}};
}

/// Whether c0 - c and D grow as the square of mu where they are read at small friction, and in proportion to each
/// other, within three errors that are small enough to tell.
bool is_second_order(const Json& readings) {
  for (const Json& reading : readings) {
    if (reading.at("id") == "at_one_depth") continue;
    const auto is = [&](const char* name, double expected) {
      const Json& fit = reading.at(name);
      if (!known(fit)) return false;
      const double error = fit.at("stderr").get<double>();
      return error < 0.25 && std::abs(fit.at("value").get<double>() - expected) <= 3 * error;
    };
    return is("gamma", 2) && is("beta", 2) && is("alpha", 1);
  }
  return false;
}

void add_headline(Json& overlay, const Json& summary, const std::string& own) {
  const Json& scaling = summary.at("scaling");
  const auto holds = [&](const char* id) { return verdict_of(summary, id) == "reproduced"; };
  for (const char* id : {"c-of-mu", "c-of-mu-as-read", "D-of-mu", "c-of-D", "differs-from-theory"}) {
    overlay["verdicts"][id] = verdict_of(summary, id);
  }
  const bool of_friction = is_friction_of_beads(summary);
  const bool powers = known(scaling.at("alpha")) && known(scaling.at("beta"));
  const bool generated = own.empty() && of_friction && known(scaling.at("gamma")) && known(scaling.at("beta"));
  bool faster = false, deeper = true;
  for (const Json& claim : summary.at("claims")) {
    const auto id = claim.at("id").get<std::string>();
    const bool of_width = id == "diffusive-width" || id.starts_with("spreading-");
    const bool too_wide = of_width && claim.at("verdict") == "not reproduced" && claim.at("z_score").is_number() &&
                          claim.at("z_score").get<double>() > 0;
    faster = faster || too_wide;
    deeper = deeper && !(too_wide && id == "diffusive-width");
  }
  const std::array<const char*, 3> of_slopes = {"c-of-mu", "D-of-mu", "c-of-D"};
  const bool slopes_have = std::ranges::all_of(of_slopes, holds);
  const bool slopes_miss =
      std::ranges::any_of(of_slopes, [&](const char* id) { return verdict_of(summary, id) == "not reproduced"; });
  overlay["headline"] = {
      {"own", own},
      {"generated", generated},
      {"moves", holds("linear-position")},
      {"diffuses", holds("diffusive-width") && !faster},
      {"faster", faster},
      {"deeper", deeper},
      {"second_order", is_second_order(scaling.at("readings"))},
      {"slopes_have", slopes_have},
      {"slopes_miss", slopes_miss},
      {"slopes_open", !slopes_have && !slopes_miss},
      {"other_window", !scaling.at("other_windows").empty() && known(scaling.at("other_windows").at(0).at("beta"))}};
  const Json& any_result = summary.at("results").empty() ? Json::object() : summary.at("results").front();
  overlay["headline"]["c0"] = fmt::format("{:.4f}", any_result.value("c0", 1 / sqrt3));
  overlay["headline"]["at"] = generated ? at_end_of_window(summary) : Json(nullptr);
  overlay["headline"]["scanned"] =
      own.empty() && !generated ? ends_of_scan(summary, powers, of_friction) : Json(nullptr);
  const Json& results = summary.at("results");
  const bool nothing = own.empty() && !generated && overlay["headline"]["scanned"].is_null() && !results.empty();
  overlay["headline"]["nothing"] =
      nothing && !known(results.back().at("c")) && results.back().at("c").contains("reason")
          ? Json{{"scanned", {{"key", place_of_scanned(summary, results.size() - 1)}}},
                 {"reason", {{"key", fmt::format("/results/{}/c/reason", results.size() - 1)}}}}
          : Json(nullptr);
  overlay["has_headline"] = !own.empty() || generated || !overlay["headline"]["scanned"].is_null() ||
                            !overlay["headline"]["nothing"].is_null();
}

namespace {

/// Whether c or D is unknown for the same reason, which then stands below their table already.
bool told_with_slopes(const Json& result, const Json& estimate) {
  if (!estimate.contains("reason")) return false;
  const auto tells = [&](const char* slope) {
    return result.at(slope).contains("reason") && result.at(slope).at("reason") == estimate.at("reason");
  };
  return tells("c") || tells("D");
}

}  // namespace

void add_laws(Json& overlay, const Json& summary) {
  Json notes = Json::array();
  std::vector<std::string> told;
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].at("exact") == true) continue;
    const std::string at = at_scanned(summary, i);
    for (const char* name : {"position", "width_squared", "amplitude", "noise"}) {
      if (told_with_slopes(results[i], results[i].at("exponents").at(name))) {
        const std::string value = at.substr(at.find("= ") + 2);
        if (told.empty() || told.back() != value) told.push_back(value);
      } else {
        add_reason(notes, summary, fmt::format("/results/{}/exponents/{}", i, name), "", "at " + at);
      }
    }
  }
  finish_notes(notes);
  overlay["law_notes"] = notes;
  overlay["told"] = enumeration(told);
}

}  // namespace granuscope
