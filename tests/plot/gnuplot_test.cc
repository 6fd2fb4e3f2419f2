#include "plot/gnuplot.h"

#include <catch2/catch.hpp>

#include "kit/search_path.h"
#include "kit/temporary_folder.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using test::TemporaryFolder;

namespace {

/// A script that writes both formats; `plot` is its plot command.
GnuplotJob job_that_plots(const std::string& plot, int curves) {
  GnuplotJob job;
  job.stem = "drawing";
  job.curves = curves;
  job.data["drawing.csv"] = "x,y\n1,1\n2,3\n";
  job.script =
      "set datafile separator comma\nset xrange [0:4]\nset yrange [0:4]\n"
      "set terminal svg font 'DejaVu Sans,12'\nset output 'drawing.svg'\n" +
      plot + "\nset terminal pdfcairo font 'DejaVu Sans,9'\nset output 'drawing.pdf'\n" + plot + "\nunset output\n";
  return job;
}

std::string message_of(const GnuplotJob& job, const std::filesystem::path& folder, double timeout = 60) {
  try {
    plot_with_gnuplot(job, folder, timeout);
  } catch (const EnvironmentError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("A sound job leaves script, data and both plots, the same bytes each time") {
  const TemporaryFolder first, second;
  const GnuplotJob job = job_that_plots("plot 'drawing.csv' using 1:2 with linespoints notitle", 1);
  plot_with_gnuplot(job, first.path());
  plot_with_gnuplot(job, second.path());
  for (const char* name : {"drawing.svg", "drawing.pdf", "drawing.gp", "drawing.csv"}) {
    INFO(name);
    CHECK(read_file(first.path() / name) == read_file(second.path() / name));
  }
  CHECK(read_file(first.path() / "drawing.pdf").find("/CreationDate") == std::string::npos);
  CHECK(std::distance(std::filesystem::directory_iterator(first.path()), std::filesystem::directory_iterator()) == 4);
}

TEST_CASE("Failures that gnuplot's exit status hides are found, and nothing is left behind") {
  const TemporaryFolder folder;
  SECTION("a data file that is not there") {
    const std::string message =
        message_of(job_that_plots("plot 'drawing.csv' using 1:2 notitle, 'none.csv' notitle", 2), folder.path());
    CHECK(message.find("none.csv") != std::string::npos);
  }
  SECTION("a column without any number") {
    GnuplotJob job = job_that_plots("plot 'drawing.csv' using 1:2 with lines notitle", 1);
    job.data["drawing.csv"] = "x,y\n1,NaN\n2,NaN\n";
    CHECK(message_of(job, folder.path()).find("column y of drawing.csv") != std::string::npos);
  }
  SECTION("a curve outside its axes") {
    const std::string message = message_of(
        job_that_plots("plot 'drawing.csv' using 1:2 with lines notitle, '' using 1:($2+90) with lines notitle", 2),
        folder.path());
    CHECK(message.find("1 of 2 curves") != std::string::npos);
  }
  SECTION("a curve that hides behind its sample in the key does not count") {
    CHECK_FALSE(message_of(job_that_plots("plot 'drawing.csv' using 1:($2+90) with lines title 'x'", 1), folder.path())
                    .empty());
  }
  SECTION("a syntax error") { CHECK_FALSE(message_of(job_that_plots("plod x", 1), folder.path()).empty()); }
  SECTION("no drawing at all") {
    GnuplotJob job = job_that_plots("", 0);
    job.script = "print_nothing = 1\n";
    CHECK(message_of(job, folder.path()).find("missing or empty") != std::string::npos);
  }
  SECTION("a script that never ends") {
    GnuplotJob job = job_that_plots("", 0);
    job.script = "while (1) { i = 1 }\n";
    CHECK(message_of(job, folder.path(), 0.3).find("still running") != std::string::npos);
  }
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("Earlier plots survive a failure") {
  const TemporaryFolder folder;
  write_file(folder.path() / "drawing.svg", "earlier");
  CHECK_FALSE(message_of(job_that_plots("plod x", 1), folder.path()).empty());
  CHECK(read_file(folder.path() / "drawing.svg") == "earlier");
}

TEST_CASE("Without gnuplot the message says how to come by it") {
  const TemporaryFolder folder;
  const test::SearchPath without_programs(folder.path());
  const std::string message = message_of(job_that_plots("plot x notitle", 1), folder.path());
  INFO(message);
  CHECK(message.find("gnuplot is not found in PATH (" + folder.path().string()) != std::string::npos);
  // Installing it again would not help where it is in a usual folder.
  const bool is_elsewhere = find_outside_path("gnuplot").has_value();
  CHECK(message.find(is_elsewhere ? "add that folder to PATH" : "apt-get install gnuplot-nox") != std::string::npos);
}

TEST_CASE("No text leaves a gnuplot string") {
  CHECK(gnuplot_string("it's") == "'it''s'");
  CHECK(gnuplot_string("'x") == "' ''x'");
  CHECK(gnuplot_string("a\nb\tc") == "'a b c'");
  const TemporaryFolder folder;
  const std::string witness = (folder.path() / "touched").string();
  const std::string hostile =
      "'; system('touch " + witness + "'); ' `touch " + witness + "` \"\n!touch " + witness + " {/Bold x}_y \\";
  const std::string plot =
      "set label 1 " + gnuplot_string(hostile) + " at 1, 1 noenhanced\nplot 'drawing.csv' using 1:2 with lines notitle";
  plot_with_gnuplot(job_that_plots(plot, 1), folder.path());
  CHECK_FALSE(std::filesystem::exists(witness));
  const std::string svg = read_file(folder.path() / "drawing.svg");
  CHECK(svg.find("`touch") != std::string::npos);
  CHECK(svg.find("{/Bold x}_y \\") != std::string::npos);
}

TEST_CASE("The creation date is blotted out in place or its absence reported") {
  const std::string pdf = "%PDF /CreationDate (D:20261121014256Z)\n %%EOF";
  CHECK(without_creation_date(pdf) == "%PDF " + std::string(33, ' ') + "\n %%EOF");
  CHECK_THROWS_AS(without_creation_date("%PDF %%EOF"), EnvironmentError);
}

TEST_CASE("A PDF of cairo 1.18 has the same bytes at any time, opens, and takes a label") {
  const std::filesystem::path data = std::filesystem::path(GRANUSCOPE_SOURCE_DIR) / "tests/data/plots";
  const std::string first = read_file(data / "cairo-1.18-first.pdf"),
                    second = read_file(data / "cairo-1.18-second.pdf");
  REQUIRE(first != second);
  const std::string pdf = without_creation_date(first);
  CHECK((without_creation_date(second) == pdf));
  CHECK(pdf.find("ObjStm") == std::string::npos);
  CHECK((with_plain_objects(pdf) == pdf));
  const TemporaryFolder folder;
  write_file(folder / "a.pdf", labelled_pdf(pdf, {"a title", "a command", "a program"}));
  const auto told_by = [&](const std::string& program, const std::vector<std::string>& more) {
    ProcessSpec process;
    process.arguments = {program, (folder / "a.pdf").string()};
    process.arguments.insert(process.arguments.end(), more.begin(), more.end());
    const ProcessResult result = run_process(process);
    CHECK(result.exit_code == 0);
    CHECK(result.standard_error == "");
    return result.standard_output;
  };
  const std::string about = told_by("pdfinfo", {});
  CHECK_THAT(about,
             Catch::Contains("a title") && Catch::Contains("a program") && Catch::Contains("Pages:           1"));
  CHECK_THAT(about, !Catch::Contains("CreationDate"));
  CHECK_THAT(told_by("pdftotext", {"-"}), Catch::Contains("-10") && Catch::Contains("10"));
}

TEST_CASE("Where TMPDIR names no folder, that is said") {
  const char* const set = getenv("TMPDIR");  // NOLINT(concurrency-mt-unsafe): tests are single-threaded
  const std::string before = set == nullptr ? "" : set;
  setenv("TMPDIR", "/nowhere", 1);  // NOLINT(concurrency-mt-unsafe)
  CHECK_THROWS_WITH(ScratchFolder("drawing"), Catch::Contains("TMPDIR names something else"));
  if (set == nullptr) {
    unsetenv("TMPDIR");  // NOLINT(concurrency-mt-unsafe)
  } else {
    setenv("TMPDIR", before.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }
}
