#include <fmt/ranges.h>

#include "cli/flag_checks.h"
#include "render/gl_context.h"
#include "report/clean_json.h"
#include "support/process.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

/// What a run of the usual size leaves: ensembles of some 100 MB and a report.
constexpr std::uintmax_t least_free_bytes = 200'000'000;

Finding look_for_program(const std::string& name, const std::string& needed_for, const std::string& package) {
  const auto program = find_installed_program(name);
  if (const auto outside = find_outside_path(name)) {
    return {name, fmt::format("{} is in no folder of PATH: {}; add it there", outside->string(), needed_for), false,
            ""};
  }
  if (!program) return {name, fmt::format("missing: {}", needed_for), false, package};
  if (!program->failure.empty()) {
    return {name, fmt::format("{} does not start: {}", program->path.string(), program->failure), false, package};
  }
  return {name, fmt::format("{}, {}", program->version, program->path.string())};
}

/// An old gnuplot starts and yet plots none of the scripts: it is asked for one point.
Finding look_for_gnuplot() {
  Finding finding = look_for_program("gnuplot", "no plots can be made", "gnuplot-nox");
  if (!finding.good) return finding;
  ProcessSpec process;
  process.arguments = {"gnuplot", "-d", "-e",
                       "set encoding utf8; set minussign; set terminal svg; plot '+' using (0):(0) notitle"};
  process.environment = {{"LC_ALL", "C.UTF-8"}, {"HOME", "/"}};
  const ProcessResult result = run_process(process);
  if (result.exit_code == 0 && result.standard_output.find("</svg>") != std::string::npos) return finding;
  finding.good = false;
  finding.package = "gnuplot-nox";
  finding.text += fmt::format(", does not plot a point: it {} {}; version 5.4 is needed", describe_end(result),
                              single_line(result.standard_error));
  return finding;
}

Finding look_for_opengl() {
  std::string why_none;
  if (const auto context = find_gl_context("auto", why_none)) {
    return {"OpenGL", fmt::format("backend {}: {}; {}, OpenGL {}", context->name(), context->reason(),
                                  context->renderer(), context->version())};
  }
  return {"OpenGL", fmt::format("none, the processor paints the same pixels: {}", why_none)};
}

Finding look_for_fonts() {
  const fs::path folder = "/usr/share/fonts";
  std::error_code code;
  for (auto at = fs::recursive_directory_iterator(folder, code); !code && at != fs::recursive_directory_iterator();
       at.increment(code)) {
    if (at->path().filename() == "DejaVuSans.ttf") return {"fonts", "DejaVu Sans, " + at->path().string()};
  }
  return {"fonts", "missing: DejaVu Sans, in which all figures are labelled", false, "fonts-dejavu-core"};
}

/// What single commands need. It is told where it is missing, which is no fault.
Finding look_for_extras() {
  const auto told = [](const char* program, const char* use, const char* packages) {
    const bool here = find_program(program).has_value();
    return fmt::format("{}, which {}, is {}", program, use,
                       here ? "here" : fmt::format("not here (apt-get install {})", packages));
  };
  return {"extras", told("ffmpeg", "joins the frames of a film", "ffmpeg") + "; " +
                        told("latex", "sets a figure in its own font", "texlive-latex-base texlive-pictures")};
}

/// Whether a file can be written there, by writing one: permissions do not tell of a read-only or a full file system.
/// A folder that is not there yet is made, and removed again with what was made above it.
Finding look_at_output(const fs::path& wanted) {
  std::error_code code;
  std::vector<fs::path> made;
  for (fs::path folder = fs::absolute(wanted, code); !fs::exists(folder, code) && folder.has_relative_path();
       folder = folder.parent_path()) {
    made.push_back(folder);
  }
  Finding finding{"results", "", true, ""};
  try {
    make_folder(wanted);
    const fs::path probe = wanted / fmt::format(".granuscope-doctor-{}", getpid());
    write_file(probe, std::string(4096, 'x'));
    fs::remove(probe, code);
    const fs::space_info space = fs::space(wanted, code);
    finding.text = code ? fmt::format("{} can be written", wanted.string())
                        : fmt::format("{} can be written, {} are free", wanted.string(),
                                      describe_bytes(static_cast<double>(space.available)));
    if (!code && space.available < least_free_bytes) {
      finding.good = false;
      finding.text += fmt::format(", but a run needs about {}; free some or choose another --out",
                                  describe_bytes(static_cast<double>(least_free_bytes)));
    }
  } catch (const EnvironmentError& error) {
    finding = {"results", fmt::format("{} Or choose another --out.", error.what()), false, ""};
  }
  for (const fs::path& folder : made) {
    if (!fs::remove(folder, code)) break;  // only if it is empty
  }
  return finding;
}

ExitCode examine(const std::string& out_folder, bool json, VerbContext& context) {
  const Provenance provenance = collect_provenance();
  (void)sha256("");  // without which no run ends: it says what is wrong with OpenSSL
  std::vector<Finding> findings{
      {"program", provenance_line(provenance)},
      {"system", provenance.operating_system},
      {"machine", fmt::format("{}, {}, {:.1f} GB of memory", provenance.host_cpu,
                              how_many(provenance.hardware_threads, "thread"), usable_memory() / 1e9)},
      {"processors", find_processors().reason},
      look_for_opengl(),
      look_for_fonts(),
      look_for_gnuplot(),
      look_for_program("weasyprint", "report.pdf is left out, and --require-pdf fails", "weasyprint"),
      look_for_extras(),
      look_at_output(out_folder),
  };
  std::vector<std::string> packages;
  bool good = true;
  for (const Finding& finding : findings) {
    if (!json)
      context.out << fmt::format("{:<4}{:<11} {}\n", finding.good ? "ok" : "--", finding.subject,
                                 single_line(finding.text));
    good = good && finding.good;
    if (!finding.good && !finding.package.empty()) packages.push_back(finding.package);
  }
  if (json) context.out << findings_json(findings);
  if (good) {
    if (!json) context.out << "everything that is needed is there\n";
    return ExitCode::done;
  }
  if (!json && !packages.empty()) {
    context.out << fmt::format("install what is missing: apt-get install --no-install-recommends {}\n",
                               fmt::join(packages, " "));
  }
  throw EnvironmentError("something that is needed is missing (the lines that begin with --)");
}

}  // namespace

void add_doctor_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "doctor", "Say what is installed, which OpenGL backend is used and why, and how to get what is missing");
  const auto out_folder = std::make_shared<std::string>("out");
  verb->add_option("-o,--out", *out_folder, "folder in which results shall be written")->capture_default_str();
  const auto json = std::make_shared<bool>(false);
  verb->add_flag("--json", *json, "print one JSON object on standard output and nothing else there");
  context.actions[verb] = [out_folder, json, &context] { return examine(*out_folder, *json, context); };
}

}  // namespace granuscope
