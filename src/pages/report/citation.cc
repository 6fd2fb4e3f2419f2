#include "report/citation.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>
#include <zip.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <ctime>
#include <memory>
#include <regex>
#include <set>
#include <utility>

#include "plot/gnuplot.h"
#include "report/clean_json.h"
#include "report/run_files.h"
#include "sampling/model_spec.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"
#include "support/progress.h"

namespace granuscope {
namespace {
std::string text_of(const YAML::Node& holder, const char* key) {
  const YAML::Node value = holder[key];
  return value && value.IsScalar() ? single_line(value.Scalar()) : "";
}

Author author_from(const YAML::Node& told) {
  Author author;
  author.family_name = text_of(told, "family-names");
  if (const std::string particle = text_of(told, "name-particle"); !particle.empty()) {
    author.family_name = particle + " " + author.family_name;
  }
  author.given_name = text_of(told, "given-names");
  author.name = text_of(told, "name");
  author.is_person = author.name.empty();  // the format has names of this key for groups only, and asks for them there
  for (const std::string& part : {author.given_name, author.family_name, text_of(told, "name-suffix")}) {
    if (author.is_person && !part.empty()) author.name += (author.name.empty() ? "" : " ") + part;
  }
  // Persons need none of their names.
  const std::string orcid = text_of(told, "orcid");
  std::smatch id;
  if (std::regex_search(orcid, id, std::regex("([0-9]{4}-){3}[0-9]{3}[0-9X]")))
    author.orcid = "https://orcid.org/" + id.str();
  for (const std::string& instead : {text_of(told, "alias"), author.orcid, text_of(told, "email"),
                                     text_of(told, "website"), text_of(told, "affiliation")}) {
    if (author.name.empty()) author.name = instead;
  }
  author.affiliation = text_of(told, "affiliation");
  return author;
}

}  // namespace

Citation read_citation(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(
        "{}: {}, so that nobody can be named by it; give a CITATION.cff with authors (Citation "
        "File Format 1.2)",
        file.string(), what);
  };
  Citation citation;
  try {
    const std::string text = read_file(file), replacement = "\xEF\xBF\xBD";
    if (text.find(replacement) == std::string::npos && clean_text(text).find(replacement) != std::string::npos)
      refuse("it is not in UTF-8, as which it is to be saved");
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) refuse("this is no citation file");
    citation = {text_of(root, "title"), {}, text_of(root, "license-url"), text_of(root, "doi"), {}};
    if (const YAML::Node identifiers = root["identifiers"];
        identifiers && citation.doi.empty() && identifiers.IsSequence()) {
      for (const YAML::Node& one : identifiers) {
        if (citation.doi.empty() && text_of(one, "type") == "doi") citation.doi = text_of(one, "value");
      }
    }
    citation.doi.erase(0, citation.doi.find("10."));  // some write it as a link
    // Software, as the format takes a work without a type, is no run, and no paper about one.
    if (text_of(root, "type") != "dataset") citation.title = citation.doi = "";
    const YAML::Node licenses = root["license"];  // one, or a list of which any may be chosen
    if (const std::string one = text_of(root, "license"); !one.empty()) citation.licenses.push_back(one);
    if (licenses && licenses.IsMap()) refuse("its licence is neither a name nor a list of names");
    for (const YAML::Node& one : licenses) citation.licenses.push_back(one.as<std::string>());
    if (const YAML::Node authors = root["authors"]; authors && authors.IsSequence()) {
      for (const YAML::Node& one : authors) {
        citation.authors.push_back(one.IsMap() ? author_from(one) : Author());
        if (citation.authors.back().name.empty())
          refuse(fmt::format("its author {} has neither name nor alias", citation.authors.size()));
      }
    }
  } catch (const YAML::Exception& error) {
    refuse("this is no YAML (" + single_line(error.what()) + ")");
  }
  if (citation.authors.empty()) refuse("it names no authors");
  return citation;
}

namespace {

/// A zip keeps the local time without its zone: the moment at which clocks here show the given one.
std::time_t moment_shown_as(const std::string& time) {
  std::tm parts = {};
  if (std::sscanf(time.c_str(), "%d-%d-%dT%d:%d:%d",  // NOLINT(cert-err34-c): a field that is missing is 0
                  &parts.tm_year, &parts.tm_mon, &parts.tm_mday, &parts.tm_hour, &parts.tm_min, &parts.tm_sec) < 3) {
    parts = std::tm();
    parts.tm_mday = parts.tm_mon = 1;
    parts.tm_year = 1980;
  }
  parts.tm_year -= 1900;
  parts.tm_mon -= 1;
  parts.tm_isdst = -1;
  return std::mktime(&parts);
}

}  // namespace

void write_zip(const std::filesystem::path& target, const std::vector<ZipEntry>& entries, const std::string& time) {
  AtomicFile file(target);
  const auto fail = [&](const std::string& why) {
    throw EnvironmentError("cannot write '{}': {}; make room or choose another --out", target.string(), why);
  };
  int code = 0;
  std::unique_ptr<zip_t, void (*)(zip_t*)> archive(
      zip_open(file.temporary_path().c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code), zip_discard);
  if (archive == nullptr) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    fail(why);
  }
  const std::time_t moment = moment_shown_as(time);
  for (const ZipEntry& entry : entries) {
    zip_source_t* source = entry.file.empty()
                               ? zip_source_buffer(archive.get(), entry.bytes.data(), entry.bytes.size(), 0)
                               : zip_source_file(archive.get(), entry.file.c_str(), 0, -1);
    if (source == nullptr) fail(zip_strerror(archive.get()));
    const zip_int64_t index = zip_file_add(archive.get(), entry.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(source);
      fail(zip_strerror(archive.get()));
    }
    const auto place = static_cast<zip_uint64_t>(index);
    constexpr zip_uint32_t plain_file = 0100644U << 16U;
    if (zip_file_set_mtime(archive.get(), place, moment, 0) != 0 ||
        zip_file_set_external_attributes(archive.get(), place, 0, ZIP_OPSYS_UNIX, plain_file) != 0) {
      fail(zip_strerror(archive.get()));
    }
  }
  // Only here are files read and the archive written, beside its place.
  if (zip_close(archive.get()) != 0) fail(zip_strerror(archive.get()));
  (void)archive.release();
  file.commit();
}

namespace {

constexpr const char* metadata_name = "ro-crate-metadata.json";
constexpr const char *manifest_name = "manifest.json", *experiment_name = "experiment.toml";
constexpr const char *codecheck_name = "codecheck.yml", *sources_name = "sources.tar.gz";
constexpr const char* process_run = "https://w3id.org/ro/wfrun/process/0.5";
// Identifiers within the crate.
constexpr const char *of_run = "#run", *of_program = "#granuscope", *of_licence = "#licence";

constexpr std::pair<const char*, const char*> formats[] = {
    {".json", "application/json"}, {".toml", "application/toml"}, {".html", "text/html"},
    {".pdf", "application/pdf"},   {".svg", "image/svg+xml"},     {".png", "image/png"},
    {".csv", "text/csv"},          {".gp", "text/plain"},         {".xml", "application/xml"},
    {".md", "text/markdown"},      {".yml", "application/yaml"},  {".gz", "application/gzip"},
    {".h5", "application/x-hdf5"}};

/// What the files at the top of a run's folder are; the others are told by their folder.
constexpr std::array<std::pair<const char*, const char*>, 14> descriptions = {
    {{"experiment.toml", "The experiment, with every default resolved"},
     {"manifest.json", "Provenance, environment and hashes of the run"},
     {"timings.json", "Wall times of its stages"},
     {"summary.json", "All numbers with their standard errors, and the verdicts"},
     {"summary.md", "The summary in Markdown"},
     {"claims.xml", "The verdicts as test results (JUnit)"},
     {"report.html", "The report"},
     {"report.pdf", "The report in print"},
     {codecheck_name, "Which figures and tables a codechecker is to make again"},
     {sources_name, "Sources of the program, of the commit that made the run"},
     {"figures/", "Figure, its script or its data"},
     {"piles/", "Contact forces of a pile"},
     {"ensembles/", "Sums over the piles that were drawn"},
     {"", "File of the run"}}};

[[noreturn]] void refuse(const fs::path& folder, const std::string& what) {
  throw InputError("{}: {}, so that the archive would not be what a run made; run it again, {}, and pack it then",
                   folder.string(), what, run_again(folder));
}

/// A path as a relative reference of a URL.
std::string as_reference(const std::string& path) {
  std::string text;
  for (const char c : path) {
    text += is_plain({&c, 1}, "-._~/") ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
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
  if (citation && citation->licenses.empty() && !citation->license_url.empty()) {
    work["license"] = reference(citation->license_url);
    graph.push_back({{"@id", citation->license_url}, {"@type", "CreativeWork"}, {"name", citation->license_url}});
  } else if (!citation || citation->licenses.empty()) {
    work["license"] = reference(of_licence);
    graph.push_back({{"@id", of_licence},
                     {"@type", "CreativeWork"},
                     {"name", "No licence is stated"},
                     {"description", "Ask the authors before you use more than the law allows."}});
  } else {
    Json all = Json::array();
    for (const std::string& name : citation->licenses) {
      // A name with other signs is none of SPDX, whose page of it there cannot be.
      const bool of_spdx = std::ranges::all_of(name, [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+';
      });
      const std::string id = of_spdx ? "https://spdx.org/licenses/" + name : fmt::format("#licence-{}", all.size() + 1);
      all.push_back(reference(id));
      graph.push_back({{"@id", id}, {"@type", "CreativeWork"}, {"name", name}});
    }
    work["license"] = all.size() == 1 ? all[0] : all;
  }
  if (!citation) return;
  if (!citation->doi.empty()) work["identifier"] = "https://doi.org/" + citation->doi;
  Json& all = work["author"] = Json::array();
  for (std::size_t i = 0; i < citation->authors.size(); ++i) {
    const Author& author = citation->authors[i];
    const bool own = !author.orcid.empty() && std::find(all.begin(), all.end(), reference(author.orcid)) == all.end();
    const std::string id = own ? author.orcid : fmt::format("#author-{}", i + 1);
    all.push_back(reference(id));
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
                  {"softwareVersion", fmt::format("{} (commit {}{}, sampling {})",
                                                  space == std::string::npos ? "" : told.substr(space + 1), commit,
                                                  provenance.at("git_dirty") == true ? " with uncommitted changes" : "",
                                                  provenance.at("sampling_version").get<std::string>())},
                  {"identifier", commit}};
  for (const auto& [library, version] : provenance.at("libraries").items()) {
    program["softwareRequirements"].push_back(fmt::format("{} {}", library, version.get<std::string>()));
  }
  return program;
}

/// Throws InputError unless `clone` has the commit that the program was built from.
std::string sources_of(const fs::path& clone, const Json& provenance) {
  const std::string told = provenance.at("git_commit");
  const std::string commit = told.substr(std::min(told.size(), told.find_first_not_of('-')));  // no option of git
  const ScratchFolder scratch("sources");
  const fs::path archive = scratch.path() / sources_name, bare = scratch.path() / "git";
  // That clone lends its objects alone: its settings and attributes may name commands.
  (void)run_process(
      {.arguments = {"git", "clone", "--quiet", "--bare", "--shared", "--", clone.string(), bare.string()},
       .working_folder = {},
       .environment = {}});
  const auto result =
      run_process({.arguments = {"git", "--git-dir", bare.string(), "archive", "--format=tar.gz",
                                 "--prefix=granuscope-" + commit.substr(0, 12) + "/", "-o", archive.string(), commit},
                   .working_folder = {},
                   .environment = {}});
  if (result.exit_code != 0) {
    throw InputError(
        "{}: git finds no commit {} there ({}), so that the sources would not be those of the "
        "program; give a clone that has it",
        clone.string(), commit, single_line(result.standard_error));
  }
  return read_file(archive);
}

/// Its DOI is left out: no source at hand confirms it.
constexpr const char *replicated_title =
                         "Stress response function of a two-dimensional ordered packing of frictional beads",
                     *replicated = "L. Breton, P. Claudin, É. Clément and J.-D. Zucker, Europhys. Lett. 60, 813 (2002)";

/// codecheck.yml (configuration 1.0): the article that `granuscope article` begins unless a citation has its title, all
/// figures of the report in its order, each with its data, and the tables. Who checks, and where the certificate is, is
/// left to be filled in.
std::string codecheck(const fs::path& folder, const Json& manifest, const Json& files, const PackOptions& options) {
  std::set<std::string> packed;
  for (const Json& file : files) packed.insert(file.at("name"));
  YAML::Emitter yaml;
  const auto entry = [&](const std::string& file, const std::string& comment) {
    if (packed.erase(file) == 0) return;
    yaml << YAML::BeginMap << YAML::Key << "file" << YAML::Value << file << YAML::Key << "comment" << YAML::Value
         << YAML::DoubleQuoted << comment << YAML::EndMap;
  };
  const Json summary = Json::parse(read_json(folder / "summary.json"));
  const std::string experiment = manifest.at("experiment"), model = summary.at("scan").at("model");
  const bool missed = std::ranges::any_of(summary.at("claims"), [](const Json& claim) {
    return claim.at("beyond_paper") != true && claim.at("verdict") == "not reproduced";
  });
  const bool of_paper = model == name_of(ModelName::frictional_beads);
  const std::string title = options.citation ? options.citation->title : "",
                    doi = options.citation ? options.citation->doi : "";
  yaml << YAML::BeginDoc << YAML::BeginMap << YAML::Key << "version" << YAML::Value
       << "https://codecheck.org.uk/spec/config/1.0/" << YAML::Key << "paper" << YAML::BeginMap << YAML::Key << "title"
       << YAML::Value << YAML::DoubleQuoted
       << (!title.empty() ? title
           : of_paper     ? fmt::format("[{}Re] {} (experiment {})", missed ? "¬" : "", replicated_title, experiment)
                          : fmt::format("Results of the experiment {}", experiment));
  if (options.citation) {
    yaml << YAML::Key << "authors" << YAML::BeginSeq;
    for (const Author& author : options.citation->authors) {
      yaml << YAML::BeginMap << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << author.name;
      if (const std::size_t id = author.orcid.rfind('/'); id != std::string::npos) {
        yaml << YAML::Key << "ORCID" << YAML::Value << author.orcid.substr(id + 1);
      }
      yaml << YAML::EndMap;
    }
    yaml << YAML::EndSeq;
  }
  if (!doi.empty() || of_paper) {
    yaml << YAML::Key << "reference" << YAML::Value << YAML::DoubleQuoted
         << (!doi.empty() ? "https://doi.org/" + doi : fmt::format("Replication of {}", replicated));
  }
  const Json& provenance = manifest.at("provenance");
  yaml << YAML::EndMap << YAML::Key << "source" << YAML::Value << YAML::DoubleQuoted
       << fmt::format("granuscope run experiment.toml --out . ({}, commit {})",
                      provenance.at("program").get<std::string>(), provenance.at("git_commit").get<std::string>());
  yaml << YAML::Key << "manifest" << YAML::BeginSeq;
  entry("summary.json", "All numbers with their standard errors, and the verdicts");
  entry("summary.md", "Tables of the claims and of c and D");
  std::size_t number = 0;
  for (const ListedFigure& figure : list_figures(folder)) {
    const std::string stem = "figures/" + figure.id, name = fmt::format("Figure {}", ++number);
    for (const char* suffix : {".pdf", ".png", ".svg"}) entry(stem + suffix, name + ": " + figure.title);
    const std::vector<std::string> left(packed.begin(), packed.end());  // entry() takes from packed
    for (const std::string& file : left) {
      const bool of_it = file == stem + ".csv" || file.starts_with(stem + "-");
      if (of_it && file.ends_with(".csv")) entry(file, "Table: data of " + name);
    }
  }
  const std::vector<std::string> left(packed.begin(), packed.end());  // entry() takes from packed
  for (const std::string& file : left) {
    if (file.ends_with(".csv")) entry(file, "Table");
  }
  yaml << YAML::EndSeq << YAML::EndMap;
  return std::string(yaml.c_str()) +
         "\n# To be added by whoever checks the run: codechecker and report, which the format wants; summary, "
         "check_time,\n# certificate.\n" +
         (options.citation ? "" : "# To be added by whoever made it: paper.authors (granuscope pack --citation).\n");
}

/// The validator of the crate's authors knows no Z.
std::string with_offset(const std::string& utc) { return utc.substr(0, utc.find('Z')) + "+00:00"; }

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
      {"conformsTo", reference(process_run)},
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
  graph.push_back({{"@id", process_run}, {"@type", "CreativeWork"}, {"name", "Process Run Crate"}, {"version", "0.5"}});
  Json results = Json::array();
  for (const Json& file : files) {
    graph.push_back(file);
    const std::string id = file.at("@id");
    if (id != experiment_name && id != codecheck_name && id != sources_name) results.push_back(reference(id));
  }
  Json run = {{"@id", of_run},
              {"@type", "CreateAction"},
              {"name", fmt::format("Run of the experiment {}", name)},
              {"description", "granuscope run experiment.toml --out ."},
              {"actionStatus", "http://schema.org/CompletedActionStatus"},
              {"endTime", with_offset(manifest.at("finished"))},
              {"instrument", reference(of_program)},
              {"object", Json::array({reference(experiment_name)})},
              {"result", results}};
  if (manifest.contains("started")) run["startTime"] = with_offset(manifest.at("started"));
  if (work.contains("author")) run["agent"] = work.at("author");
  graph.push_back(run);
  graph.push_back(program_entity(manifest.at("provenance")));
  for (const Json& one : people) graph.push_back(one);
  Json crate = {{"@context", {"https://w3id.org/ro/crate/1.1/context", {{"sha256", "https://schema.org/sha256"}}}},
                {"@graph", graph}};
  clean_strings(crate);
  return crate.dump(2) + "\n";
}

Json manifest_of_finished_run(const fs::path& folder) {
  require_visible(folder / manifest_name);
  if (!file_exists(folder / manifest_name)) {
    throw InputError("{}: there is no manifest.json, so that this is no folder of a run; name one", folder.string());
  }
  Json manifest = Json::parse(read_json(folder / manifest_name), nullptr, false);
  if (!manifest.is_object() || !manifest.contains("status")) refuse(folder, "manifest.json is damaged");
  require_results_of_last_run(folder, "report");
  if (manifest.at("status") != "done") refuse(folder, "its last run did not come to its end");
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
      const bool there = file_exists(run_folder / path);
      const std::string digest = there ? sha256_of_file(run_folder / path) : "";
      if (!there || file.at("sha256") != digest) refuse(run_folder, path + (there ? " has changed" : " is missing"));
      add(path, digest);
    }
    require_unchanged(run_folder, manifest_name);
    const auto add_made = [&](const char* name, std::string bytes) {
      files.push_back(file_entity(name, bytes.size(), sha256(bytes)));
      entries.push_back({name, "", std::move(bytes)});
    };
    add_made(codecheck_name, codecheck(run_folder, manifest, files, options));
    const Json& provenance = manifest.at("provenance");
    if (!options.sources.empty()) {
      add_made(sources_name, sources_of(options.sources, provenance));
      if (provenance.at("git_dirty") == true) files.back()["description"] = "Sources without uncommitted changes";
    }
    entries.insert(entries.begin(), {metadata_name, "", metadata(manifest, files, options)});
  } catch (const Json::exception& damage) {
    refuse(run_folder, fmt::format("manifest.json is damaged ({})", damage.what()));
  }
  write_zip(archive, entries, manifest.at("finished"));
  return entries.size();
}

}  // namespace granuscope
