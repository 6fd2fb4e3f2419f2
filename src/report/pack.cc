#include "report/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "report/clean_json.h"
#include "report/finished_run.h"
#include "report/zip_file.h"
#include "support/atomic_file.h"
#include "support/digest.h"
#include "support/error.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* metadata_name = "ro-crate-metadata.json";
constexpr const char* manifest_name = "manifest.json";
// Identifiers within the crate.
constexpr const char *of_run = "#run", *of_program = "#granuscope", *of_licence = "#licence";

constexpr std::array<std::pair<const char*, const char*>, 10> formats = {{{".json", "application/json"},
                                                                          {".toml", "application/toml"},
                                                                          {".html", "text/html"},
                                                                          {".pdf", "application/pdf"},
                                                                          {".svg", "image/svg+xml"},
                                                                          {".png", "image/png"},
                                                                          {".csv", "text/csv"},
                                                                          {".xml", "application/xml"},
                                                                          {".md", "text/markdown"},
                                                                          {".h5", "application/x-hdf5"}}};

/// What the files at the top of a run's folder are; the others are told by their folder.
constexpr std::array<std::pair<const char*, const char*>, 12> descriptions = {
    {{"experiment.toml", "The experiment, with every default resolved"},
     {"manifest.json", "Provenance, environment and hashes of the run"},
     {"timings.json", "Wall times of its stages"},
     {"summary.json", "All numbers with their standard errors, and the verdicts"},
     {"summary.md", "The summary in Markdown"},
     {"claims.xml", "The verdicts as test results (JUnit)"},
     {"report.html", "The report"},
     {"report.pdf", "The report in print"},
     {"figures/", "Figure, its script or its data"},
     {"piles/", "Contact forces of a pile"},
     {"ensembles/", "Sums over the piles that were drawn"},
     {"", "File of the run"}}};

[[noreturn]] void refuse(const fs::path& folder, const std::string& what) {
  throw InputError(
      fmt::format("{0}: {1}, so that the archive would not be what a run made; run it again, granuscope run "
                  "{0}/experiment.toml --out {0}, and pack it then",
                  folder.string(), what));
}

/// A path as a relative reference of a URL.
std::string as_reference(const std::string& path) {
  std::string text;
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~/").find(c) != std::string_view::npos;
    text += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return text;
}

Json reference(const std::string& id) { return {{"@id", id}}; }

Json file_entity(const std::string& path, std::uintmax_t bytes, const std::string& digest) {
  Json file = {{"@id", as_reference(path)}, {"@type", "File"}, {"name", path}};
  for (const auto& [beginning, description] : descriptions) {
    if (!path.starts_with(beginning)) continue;
    file["description"] = description;
    break;
  }
  const std::string extension = fs::path(path).extension().string();
  for (const auto& [known, format] : formats) {
    if (extension == known) file["encodingFormat"] = format;
  }
  file["contentSize"] = std::to_string(bytes);
  file["sha256"] = digest;
  return file;
}

/// Appends who made it, and refers to them from `work`.
void add_citation(const std::optional<Citation>& citation, Json& work, Json& graph) {
  if (!citation || citation->license.empty()) {
    work["license"] = reference(of_licence);
    graph.push_back({{"@id", of_licence},
                     {"@type", "CreativeWork"},
                     {"name", "No licence is stated"},
                     {"description", "Ask the authors before you use more than the law allows."}});
  } else {
    const std::string id = "https://spdx.org/licenses/" + as_reference(citation->license);
    work["license"] = reference(id);
    graph.push_back({{"@id", id}, {"@type", "CreativeWork"}, {"name", citation->license}});
  }
  if (!citation) return;
  if (!citation->doi.empty()) work["identifier"] = "https://doi.org/" + citation->doi;
  work["author"] = Json::array();
  for (std::size_t i = 0; i < citation->authors.size(); ++i) {
    const Author& author = citation->authors[i];
    const std::string id = author.orcid.empty() ? fmt::format("#author-{}", i + 1) : author.orcid;
    work["author"].push_back(reference(id));
    Json entity = {{"@id", id}, {"@type", author.is_person ? "Person" : "Organization"}, {"name", author.name}};
    if (!author.given_name.empty()) entity["givenName"] = author.given_name;
    if (!author.family_name.empty()) entity["familyName"] = author.family_name;
    if (!author.affiliation.empty()) entity["affiliation"] = author.affiliation;
    graph.push_back(entity);
  }
}

Json program_entity(const Json& provenance) {
  const std::string told = provenance.at("program"), commit = provenance.at("git_commit");
  const std::size_t space = told.rfind(' ');
  Json program = {{"@id", of_program},
                  {"@type", "SoftwareApplication"},
                  {"name", told.substr(0, space)},
                  {"version", space == std::string::npos ? "" : told.substr(space + 1)},
                  {"softwareVersion", fmt::format("commit {}{}, sampling {}", commit,
                                                  provenance.at("git_dirty") == true ? " with uncommitted changes" : "",
                                                  provenance.at("sampling_version").get<std::string>())},
                  {"identifier", commit}};
  for (const auto& [library, version] : provenance.at("libraries").items()) {
    program["softwareRequirements"].push_back(fmt::format("{} {}", library, version.get<std::string>()));
  }
  return program;
}

/// The research object: its graph has first the crate itself, then what is in it, then who and what made it.
std::string metadata(const Json& manifest, const Json& files, const PackOptions& options) {
  Json parts = Json::array();
  for (const Json& file : files) parts.push_back(reference(file.at("@id")));
  const std::string name = manifest.at("experiment"), told = manifest.value("description", std::string());
  Json work = {
      {"@id", "./"},
      {"@type", "Dataset"},
      {"name", options.citation && !options.citation->title.empty()
                   ? fmt::format("{}: results of the experiment {}", options.citation->title, name)
                   : fmt::format("Results of the experiment {}", name)},
      {"description", told.empty() ? "Response of piles of frictional beads to a load, by granuscope: numbers, "
                                     "figures, verdicts and report"
                                   : told},
      {"datePublished", manifest.at("finished").get<std::string>().substr(0, 10)},
      {"hasPart", parts},
      {"mentions", reference(of_run)}};
  Json people = Json::array();
  add_citation(options.citation, work, people);
  Json graph = {{{"@id", metadata_name},
                 {"@type", "CreativeWork"},
                 {"conformsTo", reference("https://w3id.org/ro/crate/1.1")},
                 {"about", reference("./")}},
                work};
  for (const Json& file : files) graph.push_back(file);
  graph.push_back({{"@id", of_run},
                   {"@type", "CreateAction"},
                   {"name", fmt::format("Run of the experiment {}", name)},
                   {"description", "granuscope run experiment.toml --out ."},
                   {"endTime", manifest.at("finished")},
                   {"instrument", reference(of_program)},
                   {"object", reference("experiment.toml")},
                   {"result", parts}});
  graph.push_back(program_entity(manifest.at("provenance")));
  for (const Json& one : people) graph.push_back(one);
  Json crate = {{"@context", {"https://w3id.org/ro/crate/1.1/context", {{"sha256", "https://schema.org/sha256"}}}},
                {"@graph", graph}};
  clean_strings(crate);
  return crate.dump(2) + "\n";
}

Json manifest_of_finished_run(const fs::path& folder) {
  std::error_code none;
  if (!fs::is_regular_file(folder / manifest_name, none)) {
    throw InputError(
        fmt::format("{}: there is no manifest.json, so that this is no folder of a run; name one", folder.string()));
  }
  Json manifest = Json::parse(read_file(folder / manifest_name), nullptr, false);
  if (!manifest.is_object() || !manifest.contains("status")) refuse(folder, "manifest.json is damaged");
  const Json stages = manifest.value("stages", Json::array());
  if (manifest.at("status") != "done" || std::find(stages.begin(), stages.end(), "report") == stages.end()) {
    refuse(folder, "its last run did not come to its end with a report");
  }
  return manifest;
}

}  // namespace

std::size_t pack_run(const fs::path& run_folder, const fs::path& archive, const PackOptions& options) {
  require_writable(archive);
  const Json manifest = manifest_of_finished_run(run_folder);
  std::vector<ZipEntry> entries;
  Json files = Json::array();
  const auto add = [&](const std::string& path, const std::string& digest) {
    std::error_code unreadable;
    files.push_back(file_entity(path, fs::file_size(run_folder / path, unreadable), digest));
    entries.push_back({path, run_folder / path, ""});
  };
  try {
    if (!lies_in(run_folder, manifest_name)) refuse(run_folder, "manifest.json is a link");
    add(manifest_name, sha256_of_file(run_folder / manifest_name));
    for (const Json& file : manifest.at("files")) {
      const std::string path = file.at("path");
      throw_if_interrupted();
      if (!lies_in(run_folder, path)) refuse(run_folder, path + " leads out of the folder");
      if (path.starts_with("ensembles/") && !options.with_ensembles) continue;
      std::error_code none;
      const bool there = fs::is_regular_file(run_folder / path, none);
      const std::string digest = there ? sha256_of_file(run_folder / path) : "";
      if (!there || file.at("sha256") != digest) refuse(run_folder, path + (there ? " has changed" : " is missing"));
      add(path, digest);
    }
    entries.insert(entries.begin(), {metadata_name, "", metadata(manifest, files, options)});
  } catch (const Json::exception& damage) {
    refuse(run_folder, fmt::format("manifest.json is damaged ({})", damage.what()));
  }
  write_zip(archive, entries, manifest.at("finished"));
  return entries.size();
}

}  // namespace granuscope
