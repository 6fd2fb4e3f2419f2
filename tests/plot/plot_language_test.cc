#include "plot/plot_texts.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <regex>
#include <tuple>

#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "plot/gnuplot.h"
#include "plot/scaling_figures.h"
#include "plot/synthetic_analysis.h"
#include "sampling/model_spec.h"
#include "support/error.h"
#include "support/templates.h"

using namespace granuscope;
using test::contains;

TEST_CASE("Texts are translated by whole words, the longest phrase first") {
  const std::string text = "depth z  (bead diameters): the paper's 0.25";
  CHECK(in_terms(text, ". -> ,\ndepth z -> Tiefe z\nbead diameters -> l'unité\nthe paper's -> l'article\n") ==
        "Tiefe z  (l'unité): l'article 0,25");
  CHECK(in_terms("slope of slopes", "slope -> A\nslopes -> B\nslope of -> C\n") == "C B");
  CHECK(in_terms(text, catalogue_of("en")) == text);
  CHECK_THROWS_AS(in_terms(text, "no arrow\n"), InputError);
  CHECK_THROWS_AS(catalogue_of("xx"), InputError);
}

TEST_CASE("French sets a space before the colon of a label, and German has its own word for a multiplexed load") {
  const std::string_view french = catalogue_of("fr");
  CHECK(in_terms("the paper, for c: 1", french) == "l'article, pour c : 1");
  CHECK(in_terms("narrow deep piles: unknown", french) == "piles étroites et profondes : inconnu");
  CHECK(in_terms("by loads (multiplexed)", catalogue_of("de")) == "durch Lasten (gemultiplext)");
}

// check_at_widths_of_journals asks the same of the names of axes and curves of every figure.
TEST_CASE("The built-in languages have a word for what the program says in certain cases only") {
  for (const char* language : {"fr", "de"}) {
    for (const char* text :
         {"slopes: γ = 1.66(4)", "small friction: γ = unknown", "slope c = 0.56", "c from thrust 0.56",
          "difference 0.1", "multiplexed, ε = 0.25, opposite, runs of 2:  c = 1,  D = 2", "fluctuation", "point",
          "paired", "twice the columns", "the paper: β ≈ 2.5", "this run: α = 0.6", "by loads (multiplexed)",
          "var w = 0.1,  3 draws per bead", "peaks not identified by the fit", "at z = 95.8: α = 0.4"}) {
      INFO(language << ": " << text);
      CHECK(words_left(text, std::string(catalogue_of(language))).empty());
    }
    for (const ModelParameter& one : model_parameters()) {  // names of axes of a scan
      INFO(language << ": " << one.meaning);
      CHECK(words_left(std::string(one.meaning), std::string(catalogue_of(language))).empty());
    }
  }
}

TEST_CASE("A figure of a run is plotted again in another language, with commas") {
  const test::TemporaryFolder run;
  const std::string id = plot_scaling_with_friction(synthetic::analysis(), run.path()).id;
  FigureStyle style;
  style.format = "svg";
  for (const auto& [language, words, in_caption] :
       {std::tuple("fr", "coefficient de frottement", "par les pentes (cercles)"),
        {"de", "Reibungszahl", "Steigungen (Kreise)"}}) {
    INFO(language);
    style.language = language;
    const PlottedFigure plotted = plot_again(run / "figures", id, style);
    CHECK(contains(plotted.bytes, words));
    CHECK(contains(plotted.bytes, ">0,1<"));
    CHECK_FALSE(contains(plotted.bytes, "friction coefficient"));
    CHECK(contains(plotted.caption, in_caption));
  }
  style.language = "it";
  CHECK_THROWS_AS(plot_again(run / "figures", id, style), InputError);
}

TEST_CASE("What fills a place of a caption is translated where all its words are known") {
  const std::string_view german = catalogue_of("de");
  const TemplateVariables places = in_words_of({{"given", "μ = 0.1, 0.2 and 0.4"},
                                                {"depth", "z = 95.8 (layer 110, 90 layers above the bottom)"},
                                                {"reason", "fewer than two points and 0.5 of them"}},
                                               german);
  CHECK(places.at("given") == "μ = 0,1; 0,2 und 0,4");
  CHECK(places.at("depth") == "z = 95,8 (Schicht 110; 90 Schichten über dem Boden)");
  CHECK(places.at("reason") == "fewer than two points and 0,5 of them");
}

TEST_CASE("A built-in translation has the captions of the same templates, with the same places in them") {
  const auto places = [](std::string_view text) {
    std::vector<std::string> names;
    const std::string all(text);
    const std::regex place("\\{\\{[#^]?([a-zA-Z_0-9/]+)\\}\\}|\\[[a-z_]+\\]\n");
    for (auto it = std::sregex_iterator(all.begin(), all.end(), place); it != std::sregex_iterator(); ++it) {
      names.push_back((*it)[1].matched ? (*it)[1].str() : it->str());
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
  };
  int compared = 0;
  for (const EmbeddedFile& file : embedded_files()) {
    if (!file.name.ends_with(".captions") || file.name.starts_with("fr/") || file.name.starts_with("de/")) continue;
    for (const std::string language : {"fr", "de"}) {
      INFO(language << "/" << file.name);
      CHECK(places(template_file(language + "/" + std::string(file.name))) == places(file.content));
    }
    ++compared;
  }
  CHECK(compared > 15);
}

TEST_CASE("A caption has at most sixty words") {
  for (const EmbeddedFile& file : embedded_files()) {
    if (!file.name.ends_with(".captions")) continue;
    INFO(file.name);
    const std::size_t begin = file.content.find("[caption]\n"), end = file.content.find("[details]\n");
    REQUIRE(begin < end);
    std::string caption(file.content.substr(begin + 10, end - begin - 10));
    // A place counts as one word, both branches of a section count, and signs between words do not.
    caption = std::regex_replace(caption, std::regex("\\{\\{[#^/][^}]*\\}\\}"), "");
    int words = 0;
    const std::regex word("[^\\s]*[A-Za-z{][^\\s]*");
    for (auto it = std::sregex_iterator(caption.begin(), caption.end(), word); it != std::sregex_iterator(); ++it)
      ++words;
    CHECK(words <= 60);
    CHECK(words >= 10);
  }
}
