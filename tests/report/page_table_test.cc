#include "report/page_scope.h"

#include <catch2/catch.hpp>
#include <stdexcept>

using namespace granuscope;
using Json = nlohmann::ordered_json;

namespace {

const Json table_summary = Json::parse(R"({
  "named": "law", "none": [],
  "rows": [{"mu": 0.1, "n": 1, "steps": [{"at": 1}, {"at": 2}]}, {"mu": 0.1, "n": 2, "steps": []},
           {"mu": 0.3, "n": 0, "steps": [{"at": 3}]}]
})");

const Json overlay = Json::parse(R"({"own": true, "others": false})");

std::string table(const std::string& text) {
  return page_table("tables/test.table", text, PageScope(table_summary, overlay, Markup::html));
}

/// The rows alone.
std::string body(const std::string& html) {
  const std::size_t start = html.find("<tbody>") + 8;
  return html.substr(start, html.find("</tbody>\n</table>") - start);
}

void check_refused(const std::string& text, const std::string& why) {
  INFO(text);
  CHECK_THROWS_AS(table(text), std::logic_error);
  CHECK_THROWS_WITH(table(text), Catch::Contains(why));
}

}  // namespace

TEST_CASE("A table of data becomes one of HTML") {
  CHECK(table("# for the test\n"
              "caption: Numbers of {{named|bare}}\n  and more\n"
              "class: loads whole\n"
              "rows: rows\n"
              "\n"
              "<var>μ</var> :: heading number :: {{mu|bare}}\n"
              "count        :: number main    :: {{n|bare}}\n"
              "what         :: name after     :: a {{../named|bare}}\n") ==
        "<div class=\"wide\" role=\"group\" aria-label=\"Table\" tabindex=\"0\">\n<table class=\"loads whole\">\n"
        "<caption><span class=\"caption\">Numbers of law\nand more</span></caption>\n"
        "<thead><tr><th scope=\"col\" class=\"num\"><var>μ</var></th><th scope=\"col\" class=\"num\">count</th>"
        "<th scope=\"col\" class=\"after\">what</th></tr></thead>\n"
        "<tbody>\n"
        "<tr><th scope=\"row\" class=\"num\">0.1</th><td class=\"num main\">1</td><td class=\"name after\">a "
        "law</td></tr>\n"
        "<tr><th scope=\"row\" class=\"num\">0.1</th><td class=\"num main\">2</td><td class=\"name after\">a "
        "law</td></tr>\n"
        "<tr><th scope=\"row\" class=\"num\">0.3</th><td class=\"num main\">0</td><td class=\"name after\">a "
        "law</td></tr>\n"
        "</tbody>\n</table>\n</div>\n");
}

TEST_CASE("A table without rows is left out") {
  CHECK(table("caption: c\nrows: none\nx :: text :: {{x}}\n").empty());
  CHECK(table("caption: c\nrows: rows\nwhere: none_of_them?\nx :: text :: {{x}}\n").empty());
}

TEST_CASE("Rows are chosen, grouped and followed by others") {
  CHECK(body(table("caption: c\nrows: rows\nwhere: n\nx :: text :: {{n|bare}}\n")) ==
        "<tr><td>1</td></tr>\n<tr><td>2</td></tr>\n");
  CHECK(body(table("caption: c\nrows: rows\nwhere: ^n\nx :: text :: {{n|bare}}\n")) == "<tr><td>0</td></tr>\n");
  CHECK(body(table("caption: c\nrows: rows\ngroup: mu\nμ :: once :: {{mu|bare}}\nx :: text :: {{n|bare}}\n")) ==
        "<tr class=\"first\"><td>0.1</td><td>1</td></tr>\n<tr><td></td><td>2</td></tr>\n"
        "</tbody>\n<tbody>\n<tr class=\"first\"><td>0.3</td><td>0</td></tr>\n");
  CHECK(body(table(
            "caption: c\nrows: rows > steps\ngroup: ../mu\nμ :: once :: {{../mu|bare}}\nx :: text :: {{at|bare}}\n")) ==
        "<tr class=\"first\"><td>0.1</td><td>1</td></tr>\n<tr><td></td><td>2</td></tr>\n"
        "</tbody>\n<tbody>\n<tr class=\"first\"><td>0.3</td><td>3</td></tr>\n");
  CHECK(body(table(
            "caption: c\nrows: rows\nafter: {{^n}}<tr><td>none</td></tr>{{/n}}\nend: <tr><td>{{named|bare}}</td></tr>\n"
            "x :: text :: {{n|bare}}\n")) ==
        "<tr><td>1</td></tr>\n<tr><td>2</td></tr>\n<tr><td>0</td></tr>\n<tr><td>none</td></tr><tr><td>law</td></tr>\n");
}

TEST_CASE("A column may be there or not, and a block of its own kind may follow") {
  const std::string html = table(
      "caption: c\nrows: rows\nx :: text :: {{n|bare}} :: others\ny :: text :: Y :: own\n"
      "z :: text :: Z :: ^others\n");
  CHECK(html.find("<th scope=\"col\">x</th>") == std::string::npos);
  CHECK(body(html).starts_with("<tr><td>Y</td><td>Z</td></tr>\n"));
  CHECK(body(table("caption: c\nrows: rows\nwhere: ^n\nx :: text :: X\nrows: rows\nwhere: ^n\ny :: number :: Y\n:: "
                   "text :: \n")) ==
        "<tr><td>X</td></tr>\n</tbody>\n<tbody>\n<tr class=\"first\"><th scope=\"col\" "
        "class=\"num\">y</th><td></td></tr>\n"
        "<tr><td class=\"num\">Y</td><td></td></tr>\n");
}

TEST_CASE("A malformed table is refused with file and line") {
  check_refused("caption: c\nrows: rows\nx : text : X\n", "templates/tables/test.table:3: ");
  check_refused("caption: c\nrows: rows\nx :: text\n", "test.table:3: a column is");
  check_refused("caption: c\nrows: rows\nx :: bold :: X\n", "test.table:3: \"bold\" is none of");
  check_refused("caption: c\nx :: text :: X\n", "test.table:2: a column before");
  check_refused("caption: c\nwhere: n\nrows: rows\nx :: text :: X\n", "test.table:2: ");
  check_refused("caption: c\nrows: rows\nx :: text :: X\nwhere: n\n", "test.table:4: ");
  check_refused("caption: c\nrows: rows\n", "rows without a column");
  check_refused("caption: c\n", "no rows");
  check_refused("rows: rows\nx :: text :: X\n", "no caption");
  check_refused("  goes on\n", "test.table:");
  check_refused("caption: c\nrows: rows\nno key\n", "test.table:3: ");
  check_refused("caption: c\nrows: rows\nx :: text :: {{nowhere}}\n", "test.table: nothing stands for {{nowhere}}");
}
