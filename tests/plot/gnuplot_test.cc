#include "plot/gnuplot.h"

#include <zlib.h>

#include <catch2/catch.hpp>

#include "kit/search_path.h"
#include "kit/temporary_folder.h"
#include "support/atomic_file.h"
#include "support/error.h"

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

TEST_CASE("Without gnuplot the message says how to install it") {
  const TemporaryFolder folder;
  const test::SearchPath without_programs(folder.path());
  CHECK(message_of(job_that_plots("plot x notitle", 1), folder.path()).find("apt-get install gnuplot-nox") !=
        std::string::npos);
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

TEST_CASE("The creation date is blotted out among packed objects, too, and nothing else moves") {
  const auto packed = [](const std::string& objects) {
    std::string bytes(compressBound(static_cast<uLong>(objects.size())), '\0');
    auto size = static_cast<uLongf>(bytes.size());
    REQUIRE(compress(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(objects.data()),
                     static_cast<uLong>(objects.size())) == Z_OK);
    bytes.resize(size);
    return bytes;
  };
  // As cairo 1.18 writes it.
  const std::string before = "%PDF-1.7\n8 0 obj\n<< /Type /ObjStm\n   /Length 9 0 R\n>>\nstream\n" +
                             packed("6 0\n[\n]\n") +
                             "\nendstream\n18 0 obj\n<< /Type /ObjStm\n   /Length 9 0 R\n>>\nstream\n";
  const std::string objects =
      "16 0 << /Producer (cairo 1.18.4)\n   /CreationDate (D:20261125124800Z)\n>>\n<< /Type /Page >>\n";
  const std::string after = "\nendstream\nstartxref\n1234\n%%EOF\n";
  const std::string pdf = before + packed(objects) + after, blank = without_creation_date(pdf);
  CHECK(blank.size() == pdf.size());
  CHECK(blank.starts_with(before));
  CHECK(blank.ends_with(after));
  std::string read(objects.size(), '\0');
  auto size = static_cast<uLongf>(read.size());
  auto length = static_cast<uLong>(blank.size() - before.size());
  REQUIRE(uncompress2(reinterpret_cast<Bytef*>(read.data()), &size,
                      reinterpret_cast<const Bytef*>(blank.data() + before.size()), &length) == Z_OK);
  const std::string date = "/CreationDate (D:20261125124800Z)";
  std::string expected = objects;
  expected.replace(expected.find(date), date.size(), date.size(), ' ');
  CHECK(read == expected);
}
