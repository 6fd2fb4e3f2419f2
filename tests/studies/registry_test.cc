#include "studies/study.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "analysis/claims.h"

using namespace granuscope;

TEST_CASE("By default no study is asked for, and its keys stand in a table of its own, within their ranges") {
  std::set<std::string> ids;
  for (const auto& study : Studies()) {
    INFO(study->id());
    CHECK(ids.insert(study->id()).second);
    CHECK_FALSE(study->asked());
    CHECK_FALSE(study->keys().empty());
    for (const Key& key : study->keys()) {
      INFO(key.path());
      CHECK(key.path() == "studies." + study->id() + "." + key.name);
      CHECK_FALSE(key.meaning.empty());
      const Problem found = find_range_problem(key);
      CHECK((found ? found->message : "") == "");
    }
  }
  CHECK_FALSE(ids.empty());
}

TEST_CASE("Studies are values: a copy has settings of its own") {
  Studies original;
  Studies copy = original;
  for (const auto& study : copy) {
    for (Key& key : study->keys()) {
      if (key.name == "samples") key.set(std::int64_t{123456});
    }
  }
  std::size_t changed = 0;
  auto theirs = copy.begin();
  for (const auto& study : original) {
    const std::vector<Key> keys = study->keys(), other_keys = (*theirs)->keys();
    for (std::size_t k = 0; k < keys.size(); ++k) {
      if (keys[k].name != "samples") continue;
      ++changed;
      CHECK(std::get<std::int64_t>(keys[k].get()) != 123456);
      CHECK(std::get<std::int64_t>(other_keys[k].get()) == 123456);
    }
    ++theirs;
  }
  CHECK(changed > 0);
}

TEST_CASE("The claims that studies decide stay open while nothing is measured, with what to ask for") {
  std::vector<std::string> ids;
  for (const auto& study : Studies()) {
    for (const Claim& claim : study->claims({})) {
      INFO(claim.id);
      ids.push_back(claim.id);
      CHECK(claim.verdict == not_tested);
      CHECK_FALSE(claim.measured.known());
      CHECK(claim.explanation.find(study->id()) != std::string::npos);
    }
  }
  CHECK(ids == std::vector<std::string>{"redraw-share", "local-rearrangements", "linear-time", "force-chains"});
}
