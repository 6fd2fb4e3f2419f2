#include "report/pdf_report.h"

#include <catch2/catch.hpp>
#include <string>

#include "kit/text_parts.h"

using namespace granuscope;
using test::contains;

namespace {

const std::string definitions =
    "\t<circle id='gpDot' r='0.5' stroke='currentColor'/>\n"
    "\t<circle id='gpPt5' stroke-width='0.2' stroke='currentColor' cx='0' cy='0' r='1'/>\n"
    "\t<use xlink:href='#gpPt5' id='gpPt6' fill='currentColor' stroke='none'/>\n";

}  // namespace

TEST_CASE("Each colour gets shapes of its own") {
  const std::string svg =
      "<svg>\n<defs>\n" + definitions +
      "</defs>\n<g color=\"black\" stroke=\"currentColor\">\n"
      "\t<use xlink:href='#gpPt6' transform='translate(1,2) scale(3)' color='rgb(  0, 114, 178)'/>\n"
      "\t<use xlink:href='#gpPt5' transform='translate(4,5) scale(3)' color='#D55E00'/>\n</g>\n</svg>\n";
  const std::string fixed = svg_for_weasyprint(svg);
  CHECK(contains(fixed, "<use xlink:href='#gpPt6-c0' transform='translate(1,2) scale(3)'/>"));
  CHECK(contains(fixed, "<use xlink:href='#gpPt5-c1' transform='translate(4,5) scale(3)'/>"));
  CHECK(contains(fixed, "<use xlink:href='#gpPt5-c0' id='gpPt6-c0' fill='rgb(  0, 114, 178)' stroke='none'/>"));
  CHECK(contains(fixed, "<circle id='gpPt5-c1' stroke-width='0.2' stroke='#D55E00' cx='0' cy='0' r='1'/>"));
  CHECK_FALSE(contains(fixed, "id='gpPt5'"));
  CHECK_FALSE(contains(fixed, "='currentColor'"));
  CHECK(contains(fixed, "stroke=\"currentColor\""));  // lines are no business of this function
}

TEST_CASE("Without points nothing changes") {
  const std::string svg = "<svg>\n<defs>\n" + definitions + "</defs>\n<path d='M0,0'/>\n</svg>\n";
  CHECK(svg_for_weasyprint(svg) == svg);
  CHECK(svg_for_weasyprint("").empty());
}
