#include "support/plain_text.h"

#include <catch2/catch.hpp>

using namespace granuscope;

TEST_CASE("text of others becomes one line that moves no cursor") {
  CHECK(single_line("") == "");
  CHECK(single_line("plain μ ∝ text") == "plain μ ∝ text");
  CHECK(single_line("line 1: bad\n  ^ here\r\n\nmore\n") == "line 1: bad   ^ here more");
  CHECK(single_line("\033[31mred\033[0m\a") == "[31mred [0m");
  CHECK(single_line("a\xc2\x9b"
                    "31m") == "a 31m");  // the same in one character, U+009B
  CHECK(single_line(std::string_view("a\0b", 3)) == "a b");
  CHECK(single_line("rm \u202e\u2066x\u2069אב\u200f") == "rm x אב\u200f");  // turned, it would read otherwise
  CHECK(single_line("\xff\xfe") == "\xff\xfe");                             // bytes of a file's name stay what they are
}

TEST_CASE("a long text is cut off between two characters") {
  CHECK(single_line("abcdef", 4) == "abcd …");
  CHECK(single_line("abcd", 4) == "abcd");
  CHECK(single_line("μμμ", 3) == "μμ …");
  CHECK(single_line(std::string(1000, 'x')).size() == 400 + std::string(" …").size());
}
