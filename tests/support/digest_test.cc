#include "support/files.h"

#include <catch2/catch.hpp>

#include "kit/temporary_folder.h"
#include "support/error.h"

using namespace granuscope;
using granuscope::test::TemporaryFolder;

TEST_CASE("SHA-256 agrees with the examples of FIPS 180-2") {
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256(std::string(1'000'000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("a file's digest is that of its bytes, however many pieces it is read in") {
  const TemporaryFolder folder;
  write_file(folder / "a", std::string(1'000'000, 'a'));
  CHECK(sha256_of_file(folder / "a") == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  write_file(folder / "empty", "");
  CHECK(sha256_of_file(folder / "empty") == sha256(""));
  CHECK_THROWS_AS(sha256_of_file(folder / "missing"), InputError);
  CHECK_THROWS_AS(sha256_of_file(folder.path()), InputError);
}

TEST_CASE("cache keys are XXH3 with 64 bits") {
  CHECK(cache_key("") == sha256("").substr(0, 16));
  CHECK(cache_key("a").size() == 16);
  CHECK(cache_key("a") != cache_key("b"));
  CHECK(cache_key(std::string("a\0b", 3)) != cache_key(std::string("a\0c", 3)));
}
