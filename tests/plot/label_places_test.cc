// Names beside points: none on another, none outside, each as near as it can be.
#include "plot/axes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

using namespace granuscope;

namespace {

constexpr double width = 2.5, height = 3;  // inches

NamedPoint named(double x, double y, const std::string& name) { return {{x, y}, {}, {}, name}; }

/// Overlap of two names as they are drawn, in square inches, from digits 0.05 inches wide and lines of 0.11.
double overlap(const LabelPlace& a, const LabelPlace& b, std::size_t characters) {
  const double text = 0.05 * static_cast<double>(characters);
  const double x = text - std::abs(a.left.x - b.left.x) * width, y = 0.11 - std::abs(a.left.y - b.left.y) * height;
  return x > 0 && y > 0 ? x * y : 0;
}

}  // namespace

TEST_CASE("a lone point has its name to the right, without a line") {
  const std::vector<LabelPlace> places = place_labels({named(0.5, 0.5, "0.3")}, {width, height, {}, {}});
  REQUIRE(places.size() == 1);
  CHECK(places[0].left.x > 0.5);
  CHECK(places[0].left.x < 0.55);
  CHECK(places[0].left.y == Approx(0.5));
  CHECK_FALSE(places[0].with_line);
}

TEST_CASE("points in every corner keep their names inside the panel") {
  const std::vector<NamedPoint> points = {named(0.01, 0.01, "corner"), named(0.99, 0.01, "corner"),
                                          named(0.01, 0.99, "corner"), named(0.99, 0.99, "corner")};
  for (const LabelPlace& place : place_labels(points, {width, height, {}, {}})) {
    CHECK(place.left.x > 0);
    CHECK(place.left.x * width + 6 * 0.05 < width);
    CHECK(place.left.y * height > 0.05);
    CHECK(place.left.y * height < height - 0.05);
  }
}

TEST_CASE("a heap of points keeps its names apart, with lines where they stand far") {
  std::vector<NamedPoint> points;
  for (int i = 0; i < 9; ++i) points.push_back(named(0.1 + 0.005 * i, 0.5 - 0.02 * i, "0.25"));
  const LabelledPanel panel{width, height, {{{0, 0.55}, {1, 0.55}}}, {}};
  const std::vector<LabelPlace> places = place_labels(points, panel);
  bool some_line = false;
  for (std::size_t i = 0; i < places.size(); ++i) {
    some_line = some_line || places[i].with_line;
    for (std::size_t j = 0; j < i; ++j) {
      INFO(i << " and " << j);
      CHECK(overlap(places[i], places[j], 4) == 0);
    }
    for (const NamedPoint& point : points) {
      const double right = places[i].left.x * width + 4 * 0.05;
      const bool covers = point.at.x * width > places[i].left.x * width && point.at.x * width < right &&
                          std::abs(point.at.y - places[i].left.y) * height < 0.05;
      CHECK_FALSE(covers);
    }
  }
  CHECK(some_line);
}

TEST_CASE("names in a column do not touch while there is room beside them") {
  std::vector<NamedPoint> points;
  for (int i = 0; i < 5; ++i) points.push_back(named(0.3, 0.6 - 0.045 * i, "0.25"));  // 0.135 inches apart
  const std::vector<LabelPlace> places = place_labels(points, {width, height, {}, {}});
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double x = std::abs(places[i].left.x - places[j].left.x) * width - 4 * 0.068;
      const double y = std::abs(places[i].left.y - places[j].left.y) * height - 0.125;
      INFO(i << " and " << j);
      CHECK(std::max(x, y) > 0.02);
    }
  }
}

TEST_CASE("a name without a line is nearer to its own point than to any other") {
  // The steep curve of c against D at small friction, where a name to the right stood beside the point above or below.
  std::vector<NamedPoint> points;
  const double D[] = {0.03, 0.035, 0.05, 0.07, 0.12, 0.27}, c[] = {0.94, 0.89, 0.82, 0.75, 0.62, 0.42};
  for (int i = 0; i < 6; ++i) points.push_back(named(D[i], c[i], "0.15"));
  const LabelledPanel panel{width, height, {{{0, 0.94}, {1, 0.94}}, {{0.03, 0.94}, {0.12, 0.62}}}, {}};
  const std::vector<LabelPlace> places = place_labels(points, panel);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].with_line) continue;
    const auto away = [&](const NamedPoint& point) {
      const double x = point.at.x * width, left = places[i].left.x * width, right = left + 4 * 0.068;
      return std::hypot(std::max({left - x, x - right, 0.0}),
                        std::max(std::abs(point.at.y - places[i].left.y) * height - 0.125 / 2, 0.0));
    };
    for (std::size_t j = 0; j < points.size(); ++j) {
      INFO(i << " and " << j);
      if (j != i) CHECK(away(points[j]) > away(points[i]));
    }
  }
}

TEST_CASE("names keep off the notes and off curves where there is room") {
  const PanelLine strip{{0, 0.8}, {0.5, 1}};
  const LabelPlace below = place_labels({named(0.1, 0.79, "0.3")}, {width, height, {}, {strip}}).front();
  CHECK(below.left.y * height + 0.05 < 0.8 * height);
  const LabelledPanel level{width, height, {{{0, 0.5}, {1, 0.5}}}, {}};
  const LabelPlace off = place_labels({named(0.5, 0.5, "0.3")}, level).front();
  CHECK(std::abs(off.left.y - 0.5) * height > 0.05);
}

TEST_CASE("no points have no places") { CHECK(place_labels({}, {width, height, {}, {}}).empty()); }
