// Experiment files changed at random: each is read or refused with a message, and what is read holds together.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "experiment/experiment.h"
#include "experiment/experiment_file.h"
#include "kit/sanitized.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;

namespace {

using Random = std::mt19937_64;

std::size_t below(std::size_t end, Random& random) {
  return std::uniform_int_distribution<std::size_t>(0, end - 1)(random);
}

/// Values that some reader somewhere has stumbled over.
const std::vector<std::string>& hostile_values() {
  static const std::vector<std::string> values{
      "nan",    "-nan",       "inf",     "-inf",       "0",          "-1",         "-0.0",        "1e999",
      "5e-324", "1.7320508",  "9e18",    "99999999",   "2147483648", "0x7fffffff", "\"\"",        "[]",
      "[[]]",   "[nan, 0.3]", "{}",      "true",       "3.5",        "1979-05-27", "\"\\u0000\"", "'`id`'",
      "\"\\\"", "[[1]]",      "{a = 1}", "[0.3, 0.1]", "[1, ]",      "1_000"};
  return values;
}

/// One of: bytes, a cut, a part twice, a line gone or elsewhere, a value replaced by a hostile one.
std::string changed(std::string text, Random& random) {
  if (text.empty()) return "x";
  switch (below(7, random)) {
    case 0:
      for (std::size_t i = below(8, random) + 1; i > 0; --i) {
        text[below(text.size(), random)] = static_cast<char>(below(256, random));
      }
      return text;
    case 1:
      return text.substr(0, below(text.size(), random));
    case 2: {
      const std::size_t from = below(text.size(), random);
      return text.insert(below(text.size(), random), text.substr(from, below(200, random)));
    }
    case 3: {
      static const std::string signs = "[]{}\"'=#.,\n\\-";
      for (std::size_t i = below(4, random) + 1; i > 0; --i) {
        text.insert(below(text.size(), random), 1, signs[below(signs.size(), random)]);
      }
      return text;
    }
    case 4: {
      const std::size_t start = text.rfind('\n', below(text.size(), random));
      const std::size_t begin = start == std::string::npos ? 0 : start;
      return text.erase(begin, text.find('\n', begin + 1) - begin);
    }
    default: {
      const std::size_t equals = text.find('=', below(text.size(), random));
      if (equals == std::string::npos) return text;
      const std::size_t end = std::min(text.find('\n', equals), text.size());
      return text.replace(equals + 1, end - equals - 1, " " + hostile_values()[below(hostile_values().size(), random)]);
    }
  }
}

std::vector<std::string> corpus() {
  std::vector<std::string> texts{print_experiment(Experiment())};
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(GRANUSCOPE_SOURCE_DIR) / "examples")) {
    if (entry.path().extension() == ".toml") texts.push_back(read_file(entry.path()));
  }
  return texts;
}

struct Tally {
  int read = 0, refused = 0;
};

void read_changed(const std::string& text, Tally& tally) {
  try {
    const Experiment experiment = parse_experiment(text, "fuzz.toml");
    ++tally.read;
    REQUIRE(find_problems(experiment).empty());
    const std::string printed = print_experiment(experiment);
    REQUIRE(print_experiment(parse_experiment(printed, "printed.toml")) == printed);
  } catch (const InputError& error) {
    ++tally.refused;
    const std::string message = error.what();
    REQUIRE(message.starts_with("fuzz.toml:"));
    REQUIRE(message.size() < 4000);
  }
}

/// Up to three changes, one after the other.
std::string changed_some(const std::vector<std::string>& texts, Random& random) {
  std::string text = texts[below(texts.size(), random)];
  for (std::size_t i = below(3, random) + 1; i > 0; --i) text = changed(std::move(text), random);
  return text;
}

}  // namespace

TEST_CASE("experiments changed at random are read or refused") {
  const std::vector<std::string> texts = corpus();
  Random random(1);
  Tally tally;
  for (int i = 0; i < 750; ++i) {
    const std::string text = changed_some(texts, random);
    CAPTURE(i, text);
    read_changed(text, tally);
  }
  CHECK(tally.read > 50);
  CHECK(tally.refused > 500);
}

TEST_CASE("experiments changed again and again", "[fuzz]") {
  constexpr double seconds = test::sanitized ? 40 : 12;
  constexpr int least = 300;
  const char* given = std::getenv("GRANUSCOPE_FUZZ_SEED");  // NOLINT(concurrency-mt-unsafe): no threads here
  const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device()();
  const std::vector<std::string> texts = corpus();
  Random random(seed);
  Tally tally;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (int i = 0; i < least || std::chrono::steady_clock::now() < end; ++i) {
    const std::string text = changed_some(texts, random);
    CAPTURE(seed, text);
    read_changed(text, tally);
  }
  std::cout << fmt::format("experiments: GRANUSCOPE_FUZZ_SEED={}: {} read, {} refused\n", seed, tally.read,
                           tally.refused);
  CHECK(tally.read > least / 10);
  CHECK(tally.refused > least / 2);
}
