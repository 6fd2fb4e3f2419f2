#include "report/pdf_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <regex>
#include <sstream>

#include "kit/search_path.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/synthetic_analysis.h"
#include "report/fixture.h"
#include "report/report.h"
#include "report/summary_json.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"
#include "support/templates.h"

using namespace granuscope;
using test::contains;

namespace {

/// Standard output of a poppler tool, run in `folder`.
std::string output_of(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  ProcessSpec process;
  process.arguments = arguments;
  process.working_folder = folder;
  process.environment = {{"LC_ALL", "C.UTF-8"}};
  const ProcessResult result = run_process(process);
  REQUIRE(result.exit_code == 0);
  return result.standard_output;
}

std::string page_text(int page, const std::filesystem::path& folder) {
  const std::string number = std::to_string(page);
  return output_of({"pdftotext", "-f", number, "-l", number, "-layout", "report.pdf", "-"}, folder);
}

int pages_of(const std::filesystem::path& folder) {
  const std::string info = output_of({"pdfinfo", "report.pdf"}, folder);
  return std::stoi(info.substr(info.find("Pages:") + 6));
}

/// How many pixels of a rasterised page have exactly this colour.
long pixels_of(const std::string& ppm, std::array<int, 3> colour) {
  std::stringstream header(ppm);
  std::string magic;
  std::size_t width = 0, height = 0, depth = 0;
  header >> magic >> width >> height >> depth;
  const std::string data = ppm.substr(ppm.size() - 3 * width * height);
  long found = 0;
  for (std::size_t at = 0; at < data.size(); at += 3) {
    bool same = true;
    for (std::size_t i = 0; i < 3; ++i) same = same && static_cast<unsigned char>(data[at + i]) == colour[i];
    found += same ? 1 : 0;
  }
  return found;
}

// Of print.css, in points.
constexpr double page_width = 210 * 72 / 25.4, page_height = 297 * 72 / 25.4, left_margin = 20 * 72 / 25.4;
constexpr double top_margin = 15 * 72 / 25.4, bottom_margin = 13 * 72 / 25.4;
constexpr double rounding = 0.5;  ///< of letters
/// Of the smallest text, in points: a subscript of a table, 77 % of 7.2, less what poppler rounds.
constexpr double least_letter = 5.4;
/// The height of poppler's box around a word over the size of its letters, for DejaVu Sans.
constexpr double box_of_a_letter = 1.164;

struct PageLayout {
  double empty_at_the_end = 0;  ///< share of the text's height, from the last ink to the margin
  double left = page_width, right = 0, least_letter = 100;
  int words = 0;
};

/// How far down a page, in points, something other than white stands above the lower margin.
double last_ink(int page, const std::filesystem::path& folder) {
  const std::string number = std::to_string(page);
  const std::string pgm =
      output_of({"pdftoppm", "-gray", "-r", "36", "-f", number, "-l", number, "report.pdf"}, folder);
  std::stringstream header(pgm);
  std::string magic;
  std::size_t width = 0, height = 0, depth = 0;
  header >> magic >> width >> height >> depth;
  const std::string data = pgm.substr(pgm.size() - width * height);
  const auto end = static_cast<std::size_t>((page_height - bottom_margin) / 72 * 36);
  for (std::size_t row = end; row-- > 0;) {
    for (std::size_t x = 0; x < width; ++x) {
      if (static_cast<unsigned char>(data[row * width + x]) < 200) return static_cast<double>(row) / 36 * 72;
    }
  }
  return 0;
}

PageLayout layout_of(int page, const std::filesystem::path& folder) {
  const std::string number = std::to_string(page);
  PageLayout layout;
  layout.empty_at_the_end = 1 - (last_ink(page, folder) - top_margin) / (page_height - top_margin - bottom_margin);
  std::stringstream words(output_of({"pdftotext", "-bbox", "-f", number, "-l", number, "report.pdf", "-"}, folder));
  for (std::string line; std::getline(words, line);) {
    if (!contains(line, "<word ")) continue;
    const auto value = [&line](const std::string& name) {
      return std::stod(line.substr(line.find(name + "=\"") + name.size() + 2));
    };
    ++layout.words;
    layout.left = std::min(layout.left, value("xMin"));
    layout.right = std::max(layout.right, value("xMax"));
    // A word that runs upwards is as wide as its letters are high; the shorter side of a long one is theirs.
    const double across = value("xMax") - value("xMin"), down = value("yMax") - value("yMin");
    if (line.find("</word>") - line.find('>') > 6)
      layout.least_letter = std::min(layout.least_letter, std::min(across, down) / box_of_a_letter);
  }
  return layout;
}

struct Written {
  test::TemporaryFolder run;
  ReportData data = synthetic::report_data(run.path());
  ReportFiles files = write_report(data, run.path(), PdfPolicy::required);
};

}  // namespace

TEST_CASE("The PDF has vector plots, all labels, contents with page numbers and the same bytes each time",
          "[unsanitized]") {
  const Written report;
  REQUIRE(report.files.pdf);
  const std::filesystem::path& folder = report.run.path();

  {
    INFO("only the picture is raster");
    const std::string images = output_of({"pdfimages", "-list", "report.pdf"}, folder);
    CHECK(std::count(images.begin(), images.end(), '\n') == 3);  // two lines of heading, one image
    CHECK(contains(images, " 800   700 "));
  }
  {
    INFO("every axis label is found");
    const std::string text = output_of({"pdftotext", "report.pdf", "-"}, folder);
    for (const char* label :
         {"position x (bead diameters)", "response P(x)", "depth z (bead diameters)", "xₚ/z", "W²/z",
          "friction coefficient μ", "diffusion coefficient D (bead diameters)", "propagation coefficient c", "c₀ − c",
          "fitted double Gaussian", "the paper: γ = 1", "residual / σ", "data / fit"}) {
      INFO(label);
      CHECK(contains(text, label));
    }
    CHECK_FALSE(contains(text, "{{"));
  }
  {
    INFO("points have their colours");
    for (int page = 1; page <= pages_of(folder); ++page) {
      if (!contains(page_text(page, folder), "c from thrust")) continue;
      const std::string number = std::to_string(page);
      const std::string ppm = output_of({"pdftoppm", "-r", "200", "-f", number, "-l", number, "report.pdf"}, folder);
      CHECK(pixels_of(ppm, {0, 114, 178}) > 1000);  // 57 measured points in two panels
      CHECK(pixels_of(ppm, {0, 158, 115}) > 50);    // c from thrust
      CHECK(pixels_of(ppm, {0, 0, 0}) > 1000);
    }
  }
  {
    INFO("the contents point at the right pages");
    const std::string contents = page_text(1, folder) + page_text(2, folder);
    const std::regex entry("([A-Z][A-Za-z.,]*(?: [A-Za-z,]+)*) ([0-9]+)(?= *·| *\\n)");
    int entries = 0;
    for (auto it = std::sregex_iterator(contents.begin(), contents.end(), entry); it != std::sregex_iterator(); ++it) {
      ++entries;
      INFO(it->str());
      CHECK(contains(page_text(std::stoi((*it)[2]), folder), (*it)[1].str()));
    }
    CHECK(entries == 7);
  }
  {
    INFO("no caption is torn from its figure");
    std::vector<std::string> pages;
    const std::string info = output_of({"pdfinfo", "report.pdf"}, folder);
    const int count = std::stoi(info.substr(info.find("Pages:") + 6));
    for (int page = 1; page <= count; ++page) {
      // In the order of reading: captions of a pair stand side by side.
      const std::string number = std::to_string(page);
      std::string words = output_of({"pdftotext", "-f", number, "-l", number, "report.pdf", "-"}, folder);
      std::erase_if(words, [](char c) { return c == ' ' || c == '\n' || c == '\f'; });
      pages.push_back(words);
    }
    for (const Figure& figure : report.data.figures) {
      std::string caption = figure.caption;
      std::erase(caption, ' ');
      INFO(figure.id);
      const std::string title = fmt::format("Figure{}.", 1 + (&figure - report.data.figures.data()));
      CHECK(std::any_of(pages.begin(), pages.end(), [&](const std::string& page) {
        return contains(page, title) && contains(page, caption.substr(0, 12)) &&
               contains(page, caption.substr(caption.size() - 12));
      }));
    }
  }
  {
    INFO("bookmarks, size and metadata");
    const std::string info = output_of({"pdfinfo", "report.pdf"}, folder);
    CHECK(contains(info, "A4"));
    CHECK(contains(info, "Synthetic numbers for tests"));
    CHECK(contains(output_of({"pdftohtml", "-xml", "-i", "-stdout", "report.pdf"}, folder), "<outline>"));
  }
  {
    INFO("no page but the last is emptier than a quarter, and nothing stands in the margins or is too small to read");
    const int count = pages_of(folder);
    for (int page = 1; page <= count; ++page) {
      CAPTURE(page);
      const PageLayout layout = layout_of(page, folder);
      if (page < count) CHECK(layout.empty_at_the_end < 0.25);
      CHECK(layout.words > 5);
      CHECK(layout.left >= left_margin - rounding);
      CHECK(layout.right <= page_width - left_margin + rounding);
      CHECK(layout.least_letter >= least_letter);
    }
  }
  {
    INFO("the same bytes");
    CHECK(pdf_report(report.data, nlohmann::ordered_json::parse(read_file(report.files.summary)), folder).bytes ==
          read_file(*report.files.pdf));
  }
  {
    INFO("nothing is left behind");
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      CHECK_FALSE(entry.path().filename().string().starts_with('.'));
    }
  }
}

TEST_CASE("No table is wider than the page") {
  const test::TemporaryFolder run;
  ReportData data = synthetic::report_data(run.path());
  data.figures.clear();
  for (Transport& result : data.analysis.results) {
    if (result.exact) continue;
    // As many digits as a large run gives, and a row for each neighbouring window.
    result.c = synthetic::known(0.5771085, 0.0000019);
    result.D = synthetic::known(0.0004891, 0.0000044);
    result.c.systematic = 9.1e-7;
    result.D.systematic = 0.000012;
    result.c_thrust = synthetic::known(0.5771196, 0.0000020);
    result.c_minus_c_thrust = synthetic::known(-0.0000111, 0.0000026);
    result.alpha_thrust = synthetic::known(0.9996166, 0.0000029);
    result.samples = 100000;
    FitVariation variation;
    variation.change = "without_shallowest_quarter";
    variation.layers = {110, 179};
    variation.depths = 24;
    variation.c = variation.D = variation.c_shift = variation.D_shift = synthetic::known(-0.000112, 0.000046);
    result.variations = {variation};
    result.fitted_area = result.centre_background = synthetic::known(-0.00326, 0.0009);
  }
  // The widest table of the studies, with numbers as long as they become.
  const nlohmann::ordered_json number = {{"value", -0.000091}, {"stderr", 0.000069}};
  for (const char* estimator : {"multiplexed", "point"}) {
    data.studies["nonlinearity"]["responses"].push_back({{"mu", 0.15},
                                                         {"estimator", estimator},
                                                         {"load", 0.25},
                                                         {"reference", false},
                                                         {"samples", 100000},
                                                         {"own_window", false},
                                                         {"window_layers", {59, 179}},
                                                         {"c", {{"value", 0.574671}, {"stderr", 0.000089}}},
                                                         {"D", {{"value", 0.00629}, {"stderr", 0.00014}}},
                                                         {"c_minus_linear", number},
                                                         {"D_over_linear_minus_1", number},
                                                         {"c_thrust_minus_uniform", number}});
  }
  data.studies["nonlinearity"]["exponents"] = nlohmann::ordered_json::array();
  data.parts.push_back({.page = "studies/nonlinearity.html",
                        .base = "/studies/nonlinearity",
                        .needs = "responses",
                        .overlay = nlohmann::ordered_json::parse(R"({
                          "paper_load": [], "paper_load_exponents": [], "notes": []})")});
  REQUIRE(write_report(data, run.path(), PdfPolicy::required).pdf);
  std::stringstream words(output_of({"pdftotext", "-bbox", "report.pdf", "-"}, run.path()));
  // A4 less the margin of 20 mm, in points; half a point for the rounding of letters.
  constexpr double right = (210 - 20) * 72 / 25.4 + 0.5;
  int found = 0;
  for (std::string line; std::getline(words, line);) {
    const std::size_t at = line.find("xMax=\"");
    if (at == std::string::npos) continue;
    ++found;
    INFO(line);
    CHECK(std::stod(line.substr(at + 6)) <= right);
  }
  CHECK(found > 1000);
}

TEST_CASE("Without WeasyPrint everything else is written and the page says why there is no PDF") {
  const test::TemporaryFolder run, empty;
  const ReportData data = synthetic::report_data(run.path());
  const test::SearchPath without_programs(empty.path());
  SECTION("if possible") {
    const ReportFiles files = write_report(data, run.path(), PdfPolicy::if_possible);
    CHECK_FALSE(files.pdf);
    const bool is_elsewhere = find_outside_path("weasyprint").has_value();
    CHECK(contains(files.pdf_skipped, is_elsewhere ? "add that folder to PATH" : "apt-get install weasyprint"));
    CHECK(contains(read_file(files.html), "weasyprint is not found in PATH"));
  }
  SECTION("required") {
    CHECK_THROWS_AS(write_report(data, run.path(), PdfPolicy::required), EnvironmentError);
    CHECK(std::filesystem::exists(run.path() / "report.html"));
  }
  SECTION("not asked for") {
    const ReportFiles files = write_report(data, run.path(), PdfPolicy::none);
    CHECK_FALSE(files.pdf);
    CHECK(contains(files.pdf_skipped, "not asked for"));
  }
  CHECK(std::filesystem::exists(run.path() / "summary.json"));
  CHECK(std::filesystem::exists(run.path() / "claims.xml"));
  CHECK(std::filesystem::exists(run.path() / "summary.md"));
  CHECK_FALSE(std::filesystem::exists(run.path() / "report.pdf"));
}

TEST_CASE("A WeasyPrint that hangs or cannot load a figure is a failure, though it ends with status 0") {
  const test::TemporaryFolder run;
  ReportData data;
  const std::string summary = summary_json(data);
  CHECK(contains(pdf_report(data, nlohmann::ordered_json::parse(summary), run.path(), 0.01).failure, "still running"));
  make_folder(run.path() / "figures");
  write_file(run.path() / "figures" / "broken.svg", "<svg xmlns='http://www.w3.org/2000/svg'><path></svg>");
  data.figures.resize(1);
  data.figures[0].screen = "figures/broken.svg";
  const PdfOutcome outcome = pdf_report(data, nlohmann::ordered_json::parse(summary_json(data)), run.path());
  CHECK(outcome.bytes.empty());
  CHECK(contains(outcome.failure, "could not load"));
}

TEST_CASE("Neither a template nor a figure has files or pages of the web put into the PDF") {
  const test::TemporaryFolder run, words;
  write_file(run / "secret.txt", "secret");
  const std::string secret = "file://" + (run / "secret.txt").string();
  const std::string page = "<!doctype html><title>short</title>";
  ReportData data;
  const auto check_refused = [&] {
    const PdfOutcome outcome = pdf_report(data, nlohmann::ordered_json::parse(summary_json(data)), run.path());
    CHECK(outcome.bytes.empty());
    CHECK_THAT(outcome.failure, Catch::Contains("could not load") && Catch::Contains("loads nothing"));
  };
  for (const std::string& element :
       {"<link rel=attachment href='" + secret + "'>", std::string("<link rel=stylesheet href='http://localhost:9/'>"),
        "<img src=&#102;" + secret.substr(1) + ">", "<a rel=attachment href='" + secret + "'>a</a>"}) {
    INFO(element);
    write_file(words / "report.html.mustache", page + element);
    use_templates(words.path());
    check_refused();
    use_templates({});
  }
  std::filesystem::remove(words / "report.html.mustache");
  write_file(words / "print.css", "@import '" + secret + "';\nbody { background: \\75rl(" + secret + ") }\n");
  use_templates(words.path());
  check_refused();
  use_templates({});
  make_folder(run.path() / "figures");
  write_file(run.path() / "figures" / "loads.svg",
             "<svg xmlns='http://www.w3.org/2000/svg' width=\"9\" height=\"9\"><image href='" + secret +
                 "' width='9' height='9'/></svg>");
  data.figures.resize(1);
  data.figures[0].screen = "figures/loads.svg";
  check_refused();
}
