// Figures of a finished run plotted again: at the widths of journals no text is clipped or lies on another.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/bead_forces.h"
#include "plot/depth_figures.h"
#include "plot/figure_texts.h"
#include "plot/gnuplot.h"
#include "plot/main_finding.h"
#include "plot/scaling_figures.h"
#include "plot/synthetic_analysis.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"
#include "support/templates.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::contains;

namespace {

/// All figures of the main line.
std::vector<std::string> plot_all(const std::filesystem::path& run) {
  const Analysis analysis = synthetic::analysis();
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.seed = 7;
  const Lattice lattice({40, 50});
  Pile pile(lattice);
  const std::vector<double> load(40, 1.0);
  REQUIRE_FALSE(make_sampler(spec, lattice)->draw(3, load, pile));
  std::vector<std::string> ids;
  ids.push_back(plot_bead_forces(pile, {}, run).id);
  if (has_main_finding(analysis)) ids.push_back(plot_main_finding(analysis, run).id);
  ids.push_back(plot_response_profiles(analysis.results, {}, run).id);
  ids.push_back(plot_transport_with_depth(analysis, {}, run).id);
  ids.push_back(plot_propagation_against_diffusion(analysis, run).id);
  ids.push_back(plot_scaling_with_friction(analysis, run).id);
  ids.push_back(plot_propagation_and_thrust(analysis, run).id);
  return ids;
}

}  // namespace

TEST_CASE("At the widths of journals no text of a figure is clipped or covered, in no language") {
  const test::TemporaryFolder run;
  for (const std::string& id : plot_all(run.path())) check_at_widths_of_journals(run / "figures", id);
}

TEST_CASE("The names of a bead's forces stand free in its picture at any contact angle") {
  for (const double angle : {30.0, 33.0, 37.0, 45.0, 47.0, 52.0, 60.0}) {
    INFO(angle << " degrees");
    const test::TemporaryFolder run;
    SamplerSpec spec;
    spec.mu = 0.3;
    spec.seed = 7;
    const Lattice lattice({40, 50, angle});
    Pile pile(lattice);
    const std::vector<double> load(40, 1.0);
    REQUIRE_FALSE(make_sampler(spec, lattice)->draw(3, load, pile));
    const std::string id = plot_bead_forces(pile, {}, run.path()).id;
    FigureStyle style;
    style.format = "svg";
    const std::string svg = plot_again(run / "figures", id, style).bytes;
    check_texts(svg);
    for (const char* name : {"θ₁", "θ₂", "θ₃", "θ₄"}) CHECK(contains(svg, name));
  }
}

TEST_CASE("The longest texts of exponents, where there is no power law, leave points and lines free") {
  const test::TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  ScalingFits &read = analysis.readings[0].fits, &small = analysis.readings[1].fits;
  read.gamma = synthetic::power_law(1.104, 0.02, -2.5, {0.1, 0.3});
  for (ScalingFit* fit : {&analysis.scaling.beta, &analysis.scaling.gamma, &analysis.scaling.alpha, &read.beta,
                          &read.gamma, &read.alpha, &small.gamma, &small.alpha}) {
    fit->scatter.chi2 = 123;
    fit->scatter.degrees_of_freedom = 4;
    REQUIRE(fit->misses_the_points());
  }
  analysis.results.back().D = synthetic::known(0.46, 0.06);
  const Figure scaling = plot_scaling_with_friction(analysis, run.path());
  CHECK(contains(scaling.details, "β = 2.54 (χ² 120/4)"));
  for (const std::string& id : {plot_main_finding(analysis, run.path()).id, scaling.id,
                                plot_propagation_against_diffusion(analysis, run.path()).id}) {
    check_at_widths_of_journals(run / "figures", id);
  }
}

TEST_CASE("An axis that ends where a number would stand has room for its numbers") {
  const test::TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (Transport& result : analysis.results) {
    for (ResponseProfile& profile : result.profiles) {
      const auto away = std::count_if(profile.x.begin(), profile.x.end(), [](double x) { return x < -100; });
      for (auto* values : {&profile.x, &profile.pressure, &profile.standard_error, &profile.fit}) {
        values->erase(values->begin(), values->begin() + away);
        values->resize(values->size() - static_cast<std::size_t>(away));
      }
      REQUIRE(profile.x.front() == -100);
    }
  }
  const std::string id = plot_response_profiles(analysis.results, {}, run.path()).id;
  const std::string svg = read_file(run / ("figures/" + id + ".svg"));
  CHECK(contains(svg, ">50<"));
  CHECK_FALSE(contains(svg, ">−100<"));
  check_at_widths_of_journals(run / "figures", id);
}

TEST_CASE("A plotted figure says by which command, in every format, and a PNG how wide it is on paper") {
  const test::TemporaryFolder run;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  FigureStyle style;
  style.language = "de";
  style.width_mm = 120;
  for (const char* format : {"pdf", "svg", "eps", "png", "tikz"}) {
    style.format = format;
    CAPTURE(format);
    const std::string bytes = plot_again(run / "figures", id, style).bytes;
    CHECK(contains(bytes, fmt::format("granuscope figure OUT {} --format {} --width 120mm --font-size 9", id, format)));
    CHECK(contains(bytes, " --language de"));
    if (style.format == "png") CHECK(contains(bytes, std::string("pHYs\0\0\x2e\x23\0\0\x2e\x23\1", 13)));
  }
}

TEST_CASE("A PNG has the pixels that are asked for, on the same paper; other formats have none") {
  const test::TemporaryFolder run;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  const auto plotted = [&](double dpi, double width_mm, const std::string& format) {
    FigureStyle style;
    style.format = format;
    style.width_mm = width_mm;
    style.dpi = dpi;
    return plot_again(run / "figures", id, style).bytes;
  };
  const std::string usual = plotted(300, 120, "png"), fine = plotted(600, 120, "png");
  const auto size_of = [](const std::string& png, std::size_t at) {
    int size = 0;
    for (std::size_t i = at; i < at + 4; ++i) size = 256 * size + static_cast<unsigned char>(png.at(i));
    return size;
  };
  constexpr std::size_t width = 16, height = 20;  // where they stand in a PNG
  CHECK(size_of(usual, width) == 1417);           // 120 mm
  CHECK(size_of(fine, width) == 2834);
  CHECK(std::abs(size_of(fine, height) - 2 * size_of(usual, height)) <= 1);
  CHECK(contains(fine, std::string("pHYs\0\0\x5c\x46\0\0\x5c\x46\1", 13)));  // 23 622 a metre
  CHECK(contains(fine, " --width 120mm --dpi 600 "));
  CHECK_THROWS_WITH(plotted(600, 120, "pdf"), Contains("pdf has no pixels"));
  CHECK_THROWS_WITH(plotted(4800, 120, "png"), Contains("choose 50 to 1200"));
  CHECK_THROWS_WITH(plotted(1200, 1000, "png"), Contains("choose 50 to 762"));
  CHECK_THROWS_WITH(plotted(std::nan(""), 120, "png"), Contains("choose 50"));
}

TEST_CASE("A figure as it is, plotted again, has the same bytes") {
  const test::TemporaryFolder run;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  for (const char* format : {"svg", "pdf"}) {
    FigureStyle style;
    style.format = format;
    std::ifstream file(run / ("figures/" + id + "." + format), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    // Each names its own command in its label: an SVG in its second element, a PDF in the update behind its first end.
    const auto drawn = [](const std::string& plot) {
      const std::size_t label = plot.find("<desc>");
      return label == std::string::npos ? plot.substr(0, plot.find("%%EOF")) : plot.substr(plot.find("</desc>"));
    };
    CHECK((drawn(plot_again(run / "figures", id, style).bytes) == drawn(bytes)));
    CHECK(drawn(bytes).size() > 5000);
  }
}

TEST_CASE("A figure is plotted in the formats of TeX, with its mathematics and without the moment") {
  const test::TemporaryFolder run;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  FigureStyle style;
  style.format = "tikz";
  const std::string tikz = plot_again(run / "figures", id, style).bytes;
  CHECK(contains(tikz, "friction coefficient \\ensuremath{\\mu}"));
  CHECK(contains(tikz, "c\\ensuremath{_0}"));
  CHECK_FALSE(std::regex_search(tikz, std::regex("[0-9]{2}:[0-9]{2}:[0-9]{2}")));
  style.format = "eps";
  const std::string eps = plot_again(run / "figures", id, style).bytes;
  CHECK(eps.starts_with("%!PS-Adobe"));
  CHECK_FALSE(contains(eps, "CreationDate"));
  style.format = "png";
  CHECK(plot_again(run / "figures", id, style).bytes.substr(1, 3) == "PNG");
}

TEST_CASE("TeX and Ghostscript take the figures of the main line as they are") {
  const test::TemporaryFolder run;
  FigureStyle style;
  style.width_mm = 86;
  const auto succeeds = [&](const std::vector<std::string>& arguments) {
    ProcessSpec process;
    process.arguments = arguments;
    process.working_folder = run.path();
    const ProcessResult result = run_process(process);
    INFO(result.standard_output << result.standard_error);
    CHECK(result.exit_code == 0);
  };
  std::string document = "\\documentclass{article}\n\\usepackage{tikz,gnuplot-lua-tikz}\n\\begin{document}\n";
  const std::vector<std::string> ids = plot_all(run.path());
  for (const std::string& id : ids) {
    style.format = "tikz";
    const std::string tikz = plot_again(run / "figures", id, style).bytes;
    INFO(id << ": a sign that TeX's fonts do not have stands in it");
    CHECK(std::all_of(tikz.begin(), tikz.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; }));
    write_file(run / (id + ".tikz"), tikz);
    document += "\\input{" + id + ".tikz}\\newpage\n";
  }
  write_file(run / "all.tex", document + "\\end{document}\n");
  if (!find_program("pdflatex") || !find_program("ps2pdf")) {
    WARN("no pdflatex or no ps2pdf here: nothing was set by TeX");
    return;
  }
  succeeds({"pdflatex", "-interaction=nonstopmode", "-halt-on-error", "all.tex"});
  CHECK(read_file(run / "all.pdf").starts_with("%PDF"));
  style.format = "eps";
  write_file(run / "one.eps", plot_again(run / "figures", ids.front(), style).bytes);
  succeeds({"ps2pdf", "-dEPSCrop", "one.eps", "one.pdf"});
  CHECK(read_file(run / "one.pdf").starts_with("%PDF"));

  // By TeX itself: its fonts, its mathematics, and the whole width (TikZ leaves some room around texts).
  style.font = "TeX";
  style.font_points = 8;
  const std::string eps = plot_again(run / "figures", ids.front(), style).bytes;
  CHECK(contains(eps, "CMMI"));  // mathematical italics
  CHECK(eps == plot_again(run / "figures", ids.front(), style).bytes);
  std::smatch box;
  REQUIRE(std::regex_search(eps, box, std::regex("%%BoundingBox: (-?[0-9]+) (-?[0-9]+) ([0-9]+) ([0-9]+)")));
  CHECK(std::stod(box[3]) - std::stod(box[1]) == Approx(86 / 25.4 * 72).margin(9));
  write_file(run / "two.eps", eps);
  succeeds({"ps2pdf", "-dEPSCrop", "two.eps", "two.pdf"});
  CHECK(read_file(run / "two.pdf").starts_with("%PDF"));
  style.format = "svg";
  CHECK_THROWS_AS(plot_again(run / "figures", ids.front(), style), InputError);
}

TEST_CASE("A figure or style that cannot be is refused") {
  const test::TemporaryFolder run;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  CHECK_THROWS_WITH(plot_again(run / "figures", "none-such", {}), Catch::Contains("the plots there are: " + id));
  CHECK_THROWS_AS(plot_again(run / "figures", "../figures/" + id, {}), InputError);
  FigureStyle narrow;
  narrow.width_mm = 20;
  CHECK_THROWS_AS(plot_again(run / "figures", id, narrow), InputError);
  FigureStyle crowded;  // gnuplot is not to blame
  crowded.width_mm = 60;
  crowded.font_points = 40;
  CHECK_THROWS_WITH(plot_again(run / "figures", id, crowded), Catch::Contains("40 pt has no room in the figure " + id));
  crowded.font_points = 9;  // gnuplot would cut the text and say nothing
  const std::string wide = plot_propagation_against_diffusion(synthetic::analysis(), run.path()).id;
  for (const char* format : {"svg", "pdf", "eps", "png"}) {
    crowded.format = format;
    CHECK_THROWS_WITH(plot_again(run / "figures", wide, crowded),
                      Catch::Contains("“diffusion coefficient D  (bead diameters)” of 9 pt has no room") &&
                          Catch::Contains("or --font-size 6.5"));
  }
  crowded.width_mm = 86;
  CHECK_NOTHROW(plot_again(run / "figures", wide, crowded));
  FigureStyle unknown;
  unknown.format = "gif";
  CHECK_THROWS_AS(plot_again(run / "figures", id, unknown), InputError);
  FigureStyle font;
  font.font = "No Such Font";
  CHECK(plot_again(run / "figures", id, font).substitute_font.size() > 3);
  CHECK_THROWS_WITH(plot_again(run / "elsewhere", id, {}),
                    Catch::Contains("name the folder that `granuscope run` wrote"));
}

TEST_CASE("Templates of an author change palette, labels, captions and house style of a finished figure") {
  const test::TemporaryFolder run, words;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  std::filesystem::create_directories(words / "plot");
  const auto changed = [&](const std::string& name, const std::string& old, const std::string& by) {
    std::string text(template_file(name));
    REQUIRE(contains(text, old));
    write_file(words / name, text.replace(text.find(old), old.size(), by));
  };
  changed("palette.txt", "#0072b2 #d55e00", "#123456 #d55e00");
  changed("plot/propagation_and_thrust.captions", "[title]\n", "[title]\nOur own title:\n");
  std::string captions = read_file(words / "plot/propagation_and_thrust.captions");
  captions.replace(captions.find("[caption]\n"), 10, "[caption]\nOur own caption.\n");
  write_file(words / "plot/propagation_and_thrust.captions", captions);
  changed("plot/begin_pass.gp.mustache", "set border linewidth 0.8", "set border linewidth 2.5");
  write_file(words / "plot/labels.txt", "speed -> celerity\n");
  FigureStyle style;
  style.format = "svg";
  const PlottedFigure before = plot_again(run / "figures", id, style);
  use_templates(words.path());
  const PlottedFigure after = plot_again(run / "figures", id, style);
  style.language = "fr";
  const PlottedFigure french = plot_again(run / "figures", id, style);
  use_templates({});
  CHECK(contains(before.bytes, "rgb(  0, 114, 178)"));
  CHECK_FALSE(contains(after.bytes, "rgb(  0, 114, 178)"));
  CHECK(contains(after.bytes, "rgb( 18,  52,  86)"));
  CHECK(contains(before.bytes, ">speed<"));
  CHECK(contains(after.bytes, ">celerity<"));
  CHECK(contains(after.bytes, "<title>Our own title"));
  CHECK(after.caption.starts_with("Our own caption. "));
  CHECK(contains(after.bytes, "stroke-width=\"2.25\""));  // 0.9 of what the script says
  CHECK_FALSE(contains(before.bytes, "stroke-width=\"2.25\""));
  CHECK(contains(french.bytes, "coefficient de frottement"));
  CHECK(contains(french.bytes, ">celerity<"));
  CHECK(french.title == after.title);  // the author's captions come before those of the language

  style.language = "fr";
  CHECK(plot_again(run / "figures", id, style).caption != before.caption);
  std::filesystem::remove(run / ("figures/" + id + ".json"));
  CHECK_THROWS_WITH(plot_again(run / "figures", id, style), Catch::Contains("run the experiment again"));
  style.trust_script = true;
  CHECK(plot_again(run / "figures", id, style).caption.empty());
  use_templates(words.path());
  CHECK_THROWS_WITH(plot_again(run / "figures", id, style), Catch::Contains("--trust-script"));
  style.trust_script = false;
  CHECK_THROWS_WITH(plot_again(run / "figures", id, style), Catch::Contains("run the experiment again"));
  use_templates({});
}

TEST_CASE("A script of an author's own stands in for the common one, and is filled from the figure's fields") {
  const test::TemporaryFolder run, words;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  std::filesystem::create_directories(words / "plot");
  write_file(words / "plot/propagation_and_thrust.gp.mustache",
             "do for [pass = 1:2] {\n{{> plot/begin_pass.gp.mustache}}\n{{#panels}}{{#y.label}}set title {{y.label}}\n"
             "{{/y.label}}{{/panels}}plot {{#panels}}{{#curves}}{{#file}}{{file}} using {{{columns}}} with "
             "{{{with}}}{{{look}}} notitle, {{/file}}{{/curves}}{{/panels}} keyentry notitle\n"
             "{{> plot/end_of_pass.gp.mustache}}\n}\n");
  FigureStyle style;
  style.format = "svg";
  use_templates(words.path());
  const std::string svg = plot_again(run / "figures", id, style).bytes;
  write_file(words / "plot/no_such_figure.gp.mustache", "");
  CHECK_THROWS_AS(use_templates(words.path()), InputError);
  use_templates({});
  CHECK(contains(svg, ">c − c₀√κ<"));
  CHECK(count_visible_curves(svg) == 3);
}

TEST_CASE("Points of the run before lie in grey behind those of this one, also where none is on the axes") {
  const test::TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure first = plot_propagation_and_thrust(analysis, run.path());
  CHECK_FALSE(contains(first.caption, "Grey"));
  const std::string table = read_file(run / first.data.at(0));
  write_file(run / "figures/last-propagation-and-thrust.csv", table);
  const Figure second = plot_propagation_and_thrust(analysis, run.path());
  CHECK(second.failure.empty());
  CHECK(contains(second.caption, "Grey: the run before."));
  REQUIRE(second.data.size() == 2);
  CHECK(read_file(run / second.data.at(0)) == table);
  const std::string svg = read_file(run / second.screen);
  const auto marks_of = [&](const std::string& curve) {
    const std::size_t at = svg.find("<title>data " + curve);
    REQUIRE(at != std::string::npos);
    return test::count(svg.substr(at, svg.find("\n\t</g>", at) - at), "<use");
  };
  CHECK(marks_of("behind-propagation-and-thrust.csv 1:2:3 yerrorbars ") ==
        marks_of("propagation-and-thrust.csv 1:2:3 yerrorbars "));
  CHECK(marks_of("propagation-and-thrust.csv 1:2:3 yerrorbars ") > 0);
  CHECK(count_visible_curves(svg) == 5);
  std::string far = table.substr(0, table.find('\n', table.find('#')) + 1) + "90,90,1,90,1,90,1\n";
  write_file(run / "figures/last-propagation-and-thrust.csv", far);
  CHECK(plot_propagation_and_thrust(analysis, run.path()).failure.empty());
  FigureStyle style;
  style.format = "svg";
  CHECK(contains(plot_again(run / "figures", second.id, style).bytes, "data behind-"));
  style.language = "fr";
  CHECK(contains(plot_again(run / "figures", second.id, style).caption, "En gris : le calcul précédent."));
}

TEST_CASE("A script that stands in a received folder is not run, unless it is trusted") {
  const test::TemporaryFolder run;
  const std::string id = plot_propagation_and_thrust(synthetic::analysis(), run.path()).id;
  const std::filesystem::path script = run / ("figures/" + id + ".gp"), trace = run / "trace";
  FigureStyle style;
  style.format = "svg";
  const PlottedFigure before = plot_again(run / "figures", id, style);
  CHECK_FALSE(before.other_script);
  write_file(script, read_file(script) + "system('touch " + trace.string() + "')\n");
  const PlottedFigure after = plot_again(run / "figures", id, style);
  CHECK(after.other_script);
  CHECK((after.bytes == before.bytes));
  CHECK_FALSE(std::filesystem::exists(trace));
  style.trust_script = true;
  CHECK_FALSE(plot_again(run / "figures", id, style).other_script);
  CHECK(std::filesystem::exists(trace));
}

TEST_CASE("A recipe with a variable that gnuplot could run, or a template that is none, is refused") {
  const test::TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const std::string profiles = plot_response_profiles(analysis.results, {}, run.path()).id;
  const std::string scaling = plot_scaling_with_friction(analysis, run.path()).id;
  const auto check_refused = [&](const std::string& id, const std::string& name, const std::string& value,
                                 const std::string& told) {
    INFO(name << " = " << value);
    const std::filesystem::path file = run / ("figures/" + id + ".json");
    const std::string good = read_file(file);
    const std::string key = nlohmann::json(name).dump() + ": ";
    REQUIRE(contains(good, key));
    const std::size_t from = good.find(key) + key.size(), end = good.find('\n', from);
    std::string evil = good;
    evil.replace(from, end - (good[end - 1] == ',' ? 1 : 0) - from, nlohmann::json(value).dump());
    write_file(file, evil);
    CHECK_THROWS_AS(plot_again(run / "figures", id, {}), InputError);
    CHECK_THROWS_WITH(plot_again(run / "figures", id, {}), Catch::Contains(told));
    write_file(file, good);
  };
  for (const char* value : {"1; system('touch x')",
                            "system('id')",
                            "1]\n!touch x\n",
                            "1]\nshell\n",
                            "`id`",
                            "$1 + 1)\nsystem('id')",
                            "\"`id`\"",
                            "@font",
                            "1] '<touch x' using 1, ",
                            "1] ' <touch x' using 1, ",
                            "load 'x'",
                            "call 'x'",
                            "eval 'x'",
                            "evaluate 'x'",
                            "set print '|id'",
                            "set output 'x'",
                            "set terminal svg",
                            "cd '..'",
                            "raise",
                            "import",
                            "exit",
                            "'a<id'[2:4]",
                            "'''<id'",
                            "{system(font)}",
                            "1 # ",
                            "1 \\\n",
                            "'unclosed",
                            "'\\write18{id}'",
                            "'<part 0>'",
                            "system"}) {
    check_refused(scaling, "function", value, "function is ");
    check_refused(scaling, "columns", value, "columns is ");
    check_refused(scaling, "with", value, "with is ");
    check_refused(scaling, "align", value, "align is ");
  }
  check_refused(profiles, "head", "\"`id`\"", "head is ");
  check_refused(profiles, "note", "<touch x", "note is ");
  check_refused(profiles, "file", "<touch x; cat ", "file is ");
  check_refused(scaling, "file", "<touch x; cat ", "file is ");
  check_refused(scaling, "file", "a' 1, system('id'), '", "file is ");
  check_refused(scaling, "colour", "#000000' . system('id') . '", "colour is ");
  check_refused(scaling, "label", "one\ntwo", "label is ");
  check_refused(scaling, "label", "\\write18{id}", "label is ");
  {
    const std::filesystem::path file = run / ("figures/" + scaling + ".json");
    const std::string good = read_file(file);
    write_file(file,
               std::regex_replace(good, std::regex("\"arrows\": \\[\\]"), "\"arrows\": [{\n\"x_in\": \"graph\"\n}]",
                                  std::regex_constants::format_first_only));
    check_refused(scaling, "x_in", "system('id')", "x_in is ");
    write_file(file, good);
  }
  check_refused(scaling, "terms", "D -> '; system('id')\n", "terms is ");
  check_refused(scaling, "id", "|touch x", "id is ");
  check_refused(scaling, "id", "another", "another figure");
  check_refused(scaling, "template", "../plot/scaling_with_friction.captions", "no template ../plot");
  check_refused(scaling, "template", "plot/response_profiles.captions", "does not fit the templates");
  // What stands where a number belongs stays a text, which gnuplot cannot run.
  for (const char* name : {"low", "from", "inches", "height"}) {
    const std::filesystem::path file = run / ("figures/" + scaling + ".json"), trace = run / "trace";
    const std::string good = read_file(file);
    write_file(file, std::regex_replace(good, std::regex(fmt::format("\"{}\": [^,\n]*", name)),
                                        fmt::format("\"{}\": \"1; system('touch {}')\"", name, trace.string())));
    try {
      plot_again(run / "figures", scaling, {});
    } catch (const InputError&) {  // gnuplot need not make a figure of it, and lacks nothing
    }
    CHECK_FALSE(std::filesystem::exists(trace));
    write_file(file, good);
  }
  CHECK_FALSE(plot_again(run / "figures", scaling, {}).bytes.empty());
  // Tables without what is to be plotted are no fault of the machine, either.
  for (const char* table : {"", "a,b,c\nx,y,z\n", "# 1\n"}) {
    for (const auto& entry : std::filesystem::directory_iterator(run / "figures")) {
      if (entry.path().extension() == ".csv") write_file(entry.path(), table);
    }
    CHECK_THROWS_AS(plot_again(run / "figures", scaling, {}), InputError);
  }
}
