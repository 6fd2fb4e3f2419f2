#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/power_law_panel.h"

using namespace granuscope;

namespace {

Range range(double low, double high) {
  Range made;
  made.add(low);
  made.add(high);
  return made;
}

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// "'0.1' 0.1 0, '' 0.3 1": label, place and level, which is left out where all are of one.
std::string text(const std::vector<Tick>& marks) {
  const bool levels = std::any_of(marks.begin(), marks.end(), [](const Tick& mark) { return mark.minor; });
  std::string list;
  for (const Tick& mark : marks) {
    list += fmt::format("{}'{}' {:.6g}{}", list.empty() ? "" : ", ", mark.label, mark.at,
                        !levels      ? ""
                        : mark.minor ? " 1"
                                     : " 0");
  }
  return list;
}

std::string linear_ticks(const Range& axis, int most) { return text(linear_marks(axis, most)); }
std::string log_ticks(const Range& axis) { return text(log_marks(axis)); }
std::string three_ticks(double reach) { return text(three_marks(reach)); }

}  // namespace

TEST_CASE("Ranges ignore what is not finite") {
  Range made;
  made.add(not_a_number);
  made.add(std::numeric_limits<double>::infinity());
  CHECK(made.empty);
  made.add(2);
  made.add(-1);
  CHECK(made.low == -1);
  CHECK(made.high == 2);
}

TEST_CASE("Linear ticks are few, round and equally long") {
  CHECK(linear_ticks(range(0, 160), 5) == "'0' 0, '50' 50, '100' 100, '150' 150");
  CHECK(linear_ticks(range(-0.11, 0.21), 4) == "'−0.1' -0.1, '0.0' 0, '0.1' 0.1, '0.2' 0.2");
  CHECK(linear_ticks(range(0.5489, 0.5791), 4) == "'0.55' 0.55, '0.56' 0.56, '0.57' 0.57");
  CHECK(linear_ticks(range(-110, 110), 5) == "'−100' -100, '−50' -50, '0' 0, '50' 50, '100' 100");
  CHECK(linear_ticks(range(0.25, 0.25), 5) == "'0.25' 0.25");
}

TEST_CASE("A low panel has three marks") {
  CHECK(three_ticks(3.45) == "'−2' -2, '0' 0, '2' 2");
  CHECK(three_ticks(4.99) == "'−2' -2, '0' 0, '2' 2");
  CHECK(three_ticks(9.9) == "'−5' -5, '0' 0, '5' 5");
  CHECK(three_ticks(27) == "'−20' -20, '0' 0, '20' 20");
}

TEST_CASE("Only labels too long for the margin ask for room") {
  constexpr double from_name = 0.091;
  CHECK(room_for_labels(linear_marks(range(0.55, 0.58), 4), from_name) == 0);
  CHECK(room_for_labels(linear_marks(range(0, 150), 4), from_name) == 0);
  // Five letters after the point: eight of 9 pt, each about 0.6 em wide, less the 30 pt of the margin, of 482 pt.
  const double room = room_for_labels(linear_marks(range(-0.00012, 0.00005), 5), from_name);
  CHECK(room == Approx((5.0 * 9 - 30) / 482).margin(0.006));
  CHECK(room_for_labels(linear_marks(range(-0.00012, 0.00005), 5), from_name - 0.01) == Approx(room + 0.01));
  CHECK(room_for_labels({{"2 × 10⁻⁴", 0.0002}, {"", 0.0003, true}}, from_name) > 0);
  CHECK(room_for_labels({{"", 0}}, from_name) == 0);
}

TEST_CASE("Logarithmic ticks name 1, 2, 5 on a short axis and decades on a long one") {
  CHECK(log_ticks(range(0.2, 0.33)) == linear_ticks(range(0.2, 0.33), 4));  // 0.2 alone would be no scale
  const Axis bare = without_words({"x", 0, 3, false, {{"a", 1}, {"", 2, true}}});
  CHECK(text(bare.ticks) == "'' 1 0, '' 2 1");
  CHECK(bare.silent);
  CHECK(log_ticks(range(0.1, 0.3)) == "'0.1' 0.1 0, '0.2' 0.2 0, '' 0.3 1");
  const std::string decades = log_ticks(range(0.01, 1));
  CHECK(decades.find("'0.01' 0.01 0") == 0);
  CHECK(decades.find("'0.1' 0.1 0") != std::string::npos);
  CHECK(decades.find("'' 0.2 1") != std::string::npos);
  CHECK(decades.find("'1' 1 0") != std::string::npos);
  // Plain digits from 0.001 to 10 000, powers of ten on an axis that goes beyond.
  CHECK(log_ticks(range(0.001, 0.1)).find("'0.001' 0.001 0") == 0);
  CHECK(log_ticks(range(9e-17, 1e-14)).find("'10⁻¹⁶' 1e-16 0") != std::string::npos);
  CHECK(log_ticks(range(9e-17, 1e-14)).find("'10⁻¹⁵' 1e-15 0") != std::string::npos);
  const std::string beads = log_ticks(range(15000, 1.1e6));
  CHECK(beads.find("'10⁵' 100000 0") != std::string::npos);
  CHECK(beads.find("'10⁶' 1e+06 0") != std::string::npos);
  CHECK(log_ticks(range(1e-4, 6e-4)).find("'2 × 10⁻⁴' 0.0002 0") != std::string::npos);
}

TEST_CASE("Windows of mu are closed and forgive rounding") {
  CHECK(in_window(0.1, {0.1, 0.3}));
  CHECK(in_window(0.1 + 0.2, {0.1, 0.3}));  // 0.30000000000000004
  CHECK_FALSE(in_window(0.31, {0.1, 0.3}));
}

TEST_CASE("CSV keeps every bit and shows unknown numbers as NaN") {
  CsvTable table({"x: beads", "y: dimensionless"});
  CHECK(table.empty());
  table.add_row({0.1, not_a_number});
  table.add_row({1.0 / 3, -2});
  CHECK(table.text() == "x,y\n#beads,dimensionless\n0.1,NaN\n0.3333333333333333,-2\n");
  for (const std::string& name : columns_without_numbers(table.text())) CHECK(name.empty());
  CHECK(columns_without_numbers("x,y\n1,NaN\n2,NaN\n") == std::vector<std::string>{"", "y"});
  CHECK(columns_without_numbers("x,y\n#beads,dimensionless\n") == std::vector<std::string>{"x", "y"});
  CHECK_THROWS_AS(CsvTable({"x", "y: beads"}), std::logic_error);
  CsvTable texts({"name", "text"});
  texts.add_cells({"a, \"b", "1.0(1)"});
  CHECK(texts.text() == "name,text\n\"a, \"\"b\",1.0(1)\n");
}

TEST_CASE("Lists and counts in words") {
  CHECK(enumeration({}).empty());
  CHECK(enumeration({"a"}) == "a");
  CHECK(enumeration({"a", "b", "c"}) == "a, b and c");
  CHECK(count_in_words(2) == "two");
  CHECK(count_in_words(14) == "14");
  CHECK(caption_number(-0.25) == "−0.25");
  CHECK(caption_number(0.3) == "0.3");
  CHECK(caption_number(133.4, 2) == "130");
  CHECK(caption_number(2.2e-14, 2) == "2.2 × 10⁻¹⁴");
}

TEST_CASE("what a figure leaves out is grouped by its reason, and mu stands once in a group") {
  CHECK(with_reasons({{"μ = 0.1", "hidden"}, {"μ = 0.2", "vague"}, {"μ = 0.3", "hidden"}, {"μ = 0.4", "hidden"}}) ==
        "μ = 0.1, 0.3 and 0.4 (hidden) and μ = 0.2 (vague)");
  CHECK(with_reasons({{"D at μ = 0.1", "hidden"}, {"μ = 0.2", "hidden"}}) == "D at μ = 0.1 and μ = 0.2 (hidden)");
  CHECK(with_reasons({}).empty());
}

TEST_CASE(
    "figures against mu send the reader to the table for what was unknown before, and say what is too uncertain") {
  Analysis analysis;
  analysis.results.resize(2);
  analysis.results[0].c = {};
  analysis.results[0].c.reason = "a long story";
  analysis.results[0].D.value = 1;
  analysis.results[0].D.standard_error = 0.6;
  analysis.results[1].c.value = 0.5;
  analysis.results[1].c.standard_error = 0.01;
  const Analysis clear = without_imprecise_points(analysis);
  CHECK(clear.results[0].c.reason == "why stands under the table of c and D");
  CHECK_FALSE(clear.results[0].D.known());
  CHECK(clear.results[0].D.reason.starts_with("too uncertain for a point: 1"));
  CHECK(clear.results[1].c.known());
  CHECK(analysis.results[0].c.reason == "a long story");
}
