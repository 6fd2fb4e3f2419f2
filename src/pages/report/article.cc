#include "report/article.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "plot/gnuplot.h"
#include "report/number_text.h"
#include "report/page_scope.h"
#include "report/run_files.h"
#include "sampling/model_spec.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {
namespace {
std::string macro(const std::string& name) { return "\\granuscope{" + name + "}"; }

/// What the templates say beside summary.json.
Json article_overlay(const Json& summary, const Json& provenance, const std::filesystem::path& figures,
                     const std::optional<Citation>& citation) {
  int reproduced = 0, failed = 0, open = 0;
  Json overlay, claims = Json::array();
  const Json& all = summary.at("claims");
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].at("beyond_paper") == true) continue;
    claims.push_back({{"key", fmt::format("/claims/{}", i)},
                      {"macro", macro(fmt::format("claims/{}/measured", all[i].at("id").get<std::string>()))}});
    ++(all[i].at("verdict") == "reproduced" ? reproduced : all[i].at("verdict") == "not reproduced" ? failed : open);
  }
  overlay["claims_list"] = claims;
  overlay["claims"] = fmt::format("{} reproduced, {} not reproduced, {} open", reproduced, failed, open);
  overlay["failed"] = failed > 0;
  overlay["program"] = fmt::format("{}, commit {}", provenance.at("program").get<std::string>(),
                                   provenance.at("git_commit").get<std::string>().substr(0, 12));
  overlay["authors"] = Json::array();
  std::vector<Author> authors(1);
  authors[0].name = "Nobody yet";
  if (citation) authors = citation->authors;
  for (std::size_t i = 0; i < authors.size(); ++i) {
    const Author& one = authors[i];
    // What JSON quotes is quoted in YAML, too.
    overlay["authors"].push_back({{"name", one.name},
                                  {"number", std::to_string(i + 1)},
                                  {"more", i + 1 < authors.size()},
                                  {"quoted_name", Json(one.name).dump()},
                                  {"quoted_orcid", Json(one.orcid.substr(one.orcid.rfind('/') + 1)).dump()},
                                  {"quoted_affiliation", Json(one.affiliation).dump()}});
  }
  overlay["results"] = Json::array();
  const std::string scanned = scanned_in(summary);
  for (std::size_t i = 0; i < summary.at("results").size(); ++i) {
    const std::string name = fmt::format("{}-{}", scanned, exact(summary.at("results")[i].at(scanned).get<double>()));
    overlay["results"].push_back({{"macro_c", macro(name + "/c")},
                                  {"macro_D", macro(name + "/D")},
                                  {"scanned", {{"key", place_of_scanned(summary, i)}}}});
  }
  overlay["sampled"] = "";
  for (const Json& one : summary.at("results")) {
    if (one.at("exact") == true) continue;
    overlay["sampled"] =
        fmt::format("They follow the law {}, and the estimator {} measures the response{}{}.",
                    one.at("law").get<std::string>(), one.at("estimator").get<std::string>(),
                    one.value("overloads", 1) > 1 ? ", with two overloads a pile where friction is small enough" : "",
                    one.value("coupled", false) ? ", in groups of eight piles that share their random numbers" : "");
    break;
  }
  overlay["figures"] = Json::array();
  for (const Json& figure : summary.at("figures")) {
    const auto id = figure.at("id").get<std::string>();
    const bool plotted = std::filesystem::is_regular_file(figures / (id + ".pdf"));
    overlay["figures"].push_back({{"file", id + (plotted ? ".pdf" : ".png")}});
  }
  return overlay;
}

}  // namespace

void write_article(const std::filesystem::path& run_folder, const std::filesystem::path& target,
                   const std::optional<Citation>& citation) {
  require_results_of_last_run(run_folder, "report");
  for (const char* part : {"summary.json", "figures/"}) require_unchanged(run_folder, part);
  std::error_code none;
  if (std::filesystem::exists(target, none) && !std::filesystem::is_empty(target, none)) {
    throw InputError("{}: there are files, which an article would mix with or replace; give a new folder",
                     target.string());
  }
  const std::string text = read_json(run_folder / "summary.json");
  const std::string numbers = list_numbers(text, "tex", {});  // looks whether it is a summary
  Json summary, overlay;
  try {
    summary = Json::parse(text);
    if (const std::string model = summary.at("scan").at("model"); model != name_of(ModelName::frictional_beads)) {
      throw InputError(
          "{}: this run is of the model {}, and the paper that an article replicates is about frictional beads; run "
          "an experiment with those",
          run_folder.string(), model);
    }
    const Json manifest = Json::parse(read_json(run_folder / "manifest.json"));
    overlay = article_overlay(summary, manifest.at("provenance"), run_folder / "figures", citation);
  } catch (const Json::exception& damage) {
    throw InputError("{}: summary.json or manifest.json is damaged ({}); run the experiment again", run_folder.string(),
                     damage.what());
  }
  // Whole or not at all: made beside the place where it is to be, and moved there.
  const std::filesystem::path whole = std::filesystem::absolute(target, none).lexically_normal();
  const std::filesystem::path named = whole.has_filename() ? whole : whole.parent_path();
  const ScratchFolder scratch(named.parent_path(), named.filename().string());
  const std::filesystem::path article = scratch.path() / "article";
  make_folder(article / "figures");
  for (const Json& figure : overlay.at("figures")) {
    const auto file = std::filesystem::path("figures") / figure.at("file").get<std::string>();
    write_file(article / file, read_file(run_folder / file));
  }
  for (const char* name : {"content.tex", "title.tex", "metadata.yaml"}) {
    const Markup markup = std::string_view(name).ends_with(".tex") ? Markup::tex : Markup::plain;
    write_file(article / name,
               fill_template_file(fmt::format("article/{}.mustache", name), PageScope(summary, overlay, markup)));
  }
  for (const char* name : {"article.tex", "bibliography.bib"}) {
    write_file(article / name, template_file(std::string("article/") + name));
  }
  write_file(article / "numbers.tex", numbers);
  std::error_code error;
  std::filesystem::rename(article, named, error);
  if (error) {
    throw EnvironmentError("the article cannot be moved to '{}': {}; check the permissions", target.string(),
                           error.message());
  }
}

}  // namespace granuscope
