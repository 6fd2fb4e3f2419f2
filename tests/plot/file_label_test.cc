// What the files of figures say of themselves, read by others' eyes.
#include "plot/gnuplot.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "kit/temporary_folder.h"
#include "plot/figure_captions.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;

namespace {

const std::string program = "granuscope 0.1.0, commit 0123456789, GNU 12.2.0";

/// A figure as a run makes it.
Figure plotted(const std::filesystem::path& run_folder) {
  GnuplotJob job;
  job.stem = "drawing";
  job.data = {{"drawing.csv", "# x, y\n1,1\n2,4\n"}};
  job.curves = 1;
  job.script =
      "set datafile separator ','\nset terminal svg\nset output 'drawing.svg'\nplot 'drawing.csv' with linespoints "
      "notitle\nset terminal pdfcairo\nset output 'drawing.pdf'\nreplot\nset output\n";
  Figure figure;
  figure.id = "drawing";
  figure.title = "c \u2212 c\u2080 < D & \"\u03bc\"";
  figure.screen = "figures/drawing.svg";
  figure.print = "figures/drawing.pdf";
  figure.redraw = "cd figures && gnuplot -d drawing.gp";
  job.label = FileLabel{figure.title, figure.redraw, program};
  std::filesystem::create_directories(run_folder / "figures");
  plot_with_gnuplot(job, run_folder / "figures");
  return figure;
}

}  // namespace

TEST_CASE("SVG and PDF of a figure carry its title, command and commit, no date, and the same bytes each time") {
  const TemporaryFolder one, other;
  const Figure figure = plotted(one.path());
  plotted(other.path());
  for (const char* file : {"figures/drawing.svg", "figures/drawing.pdf"}) {
    INFO(file);
    CHECK((read_file(one / file) == read_file(other / file)));
  }
  ProcessSpec pdfinfo;
  pdfinfo.arguments = {"pdfinfo", (one / "figures/drawing.pdf").string()};
  pdfinfo.environment = {{"LC_ALL", "C.UTF-8"}};
  const ProcessResult told = run_process(pdfinfo);
  CHECK(told.standard_error.empty());  // the cross-references are right
  CHECK_THAT(told.standard_output, Contains(figure.title) && Contains(figure.redraw) && Contains(program));
  CHECK_THAT(told.standard_output, Contains("Pages:           1") && !Contains("Date"));

  const auto label = label_of_svg(read_file(one / "figures/drawing.svg"));
  REQUIRE(label);
  CHECK(label->title == figure.title);
  CHECK(label->command == figure.redraw);
  CHECK(label->program == program);
  CHECK_THAT(read_file(one / "figures/drawing.svg"), !Contains("Produced by GNUPLOT"));
}

TEST_CASE("A figure plotted again keeps the title and the commit of its run") {
  const TemporaryFolder folder;
  const Figure figure = plotted(folder.path());
  write_file(folder / "figures/drawing.gp",
             "set datafile separator ','\nset terminal svg\nset output 'drawing.svg'\nplot 'drawing.csv' with lines\n");
  FigureStyle style{"svg", 90};
  style.trust_script = true;  // this one has been written by hand
  const auto label = label_of_svg(plot_again(folder / "figures", "drawing", style).bytes);
  REQUIRE(label);
  CHECK(label->title == figure.title);
  CHECK(label->command == "granuscope figure OUT drawing --format svg --width 90mm --font-size 9 --font 'DejaVu Sans'");
  CHECK(label->program == program);
}

TEST_CASE("Files of another build of gnuplot are refused") {
  CHECK_THROWS_AS(labelled_svg("<svg></svg>", {}), EnvironmentError);
  CHECK_THROWS_AS(labelled_pdf("%PDF-1.7\nstartxref\n%%EOF\n", {}), EnvironmentError);
  CHECK_FALSE(label_of_svg("<svg><title>Gnuplot</title><desc>Produced by GNUPLOT</desc></svg>"));
}

TEST_CASE("A PDF string is plain or UTF-16") {
  CHECK(pdf_string("a (b) \\") == "(a \\(b\\) \\\\)");
  CHECK(pdf_string("\u03bc") == "<FEFF03BC>");
  CHECK(pdf_string("\U0001D6FD") == "<FEFFD835DEFD>");
}
