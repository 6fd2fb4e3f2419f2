#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "kit/png_image.h"
#include "kit/temporary_folder.h"
#include "render/font.h"
#include "render/gl_context.h"
#include "render/picture_distance.h"
#include "render/render_pile.h"
#include "render/scenes.h"
#include "render/test_piles.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;

const fs::path pictures = fs::path(GRANUSCOPE_SOURCE_DIR) / "tests/data/pictures";

struct Golden {
  std::string name;
  SceneSpec spec;
};

std::vector<Golden> goldens() {
  const auto spec = [](const char* scene, const char* colour_map, int width = 300, double dpi = 72) {
    SceneSpec one;
    one.scene = scene;
    one.colour_map = colour_map;
    one.width_px = width;
    one.dpi = dpi;
    return one;
  };
  std::vector<Golden> all = {{"forces", spec("forces", "grey")},
                             {"forces-of-window", spec("forces", "cividis", 320, 110)},
                             {"forces-far-away", spec("forces", "grey", 130)},
                             {"forces-transparent", spec("forces", "viridis")},
                             {"weight", spec("weight", "grey")},
                             {"friction", spec("friction", "viridis")},
                             {"response", spec("response", "diverging")},
                             {"field", spec("field", "grey")}};
  all[1].spec.window = {{-20, -5, 12, 21}};
  all[3].spec.background = Background::transparent;
  return all;
}

/// Two bands that leave the middle and widen, with a ray and an envelope: exact numbers only.
Field field_of_two_bands() {
  Field field;
  field.key_title = "P(x, z)";
  for (int row = 0; row < 12; ++row) {
    FieldRow cells{2.0 + 3 * row, -24, {}};
    for (int k = 0; k < 48; ++k) {
      const double from_band = std::abs(std::abs(k + 0.5 - 24) - 0.5 * cells.z) / (1 + 0.125 * cells.z);
      cells.values.push_back(0.25 / (1 + from_band * from_band) - 0.03125);
    }
    field.rows.push_back(cells);
  }
  field.lines = {{{{1, 2}, {17.5, 35}}, false}, {{{-1, 2}, {-17.5, 35}}, true}};
  return field;
}

Image drawn(const Golden& golden, const fs::path& image) {
  if (golden.spec.scene == "field") {
    render_scene(build_field_scene(field_of_two_bands(), golden.spec), golden.spec, image);
  } else {
    const bool pair = golden.spec.scene == "response";
    render_pile_file({pictures / "point.h5", pair ? pictures / "uniform.h5" : "", image}, golden.spec);
  }
  return test::read_png(image);
}

/// A folder's name: what the renderer calls itself, without what a name should not have.
std::string key_of(const GlContext& context) {
  std::string key;
  for (const char c : context.renderer() + " " + context.version() + " " + typesetter()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.';
    if (plain) key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (!plain && !key.empty() && key.back() != '-') key += '-';
  }
  return key;
}

TEST_CASE("every scene is rendered as it was: the same pixels by the same renderer, nearly the same by any other",
          "[golden]") {
  const std::string here = key_of(*make_gl_context("auto"));
  INFO("drawn by " << here);
  const bool renew = std::getenv("GRANUSCOPE_RENEW_PICTURES") != nullptr;
  if (renew) fs::create_directories(pictures / here);
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(pictures)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  REQUIRE_FALSE(folders.empty());

  const test::TemporaryFolder scratch;
  for (const Golden& golden : goldens()) {
    const Image now = drawn(golden, scratch / "now.png");
    for (const fs::path& folder : folders) {
      const fs::path old = folder / (golden.name + ".png");
      INFO(old.string());
      if (renew && folder.filename() == here) {
        fs::copy_file(scratch / "now.png", old, fs::copy_options::overwrite_existing);
      }
      const Image before = test::read_png(old);
      bool same = before.width == now.width && before.height == now.height;
      REQUIRE(same);
      const PictureDistance apart = distance(before, now);
      INFO("root mean square " << apart.root_mean_square << ", of blocks " << apart.blocks << ", mean " << apart.mean
                               << ", largest " << apart.largest);
      if (folder.filename() == here) {
        same = before.rgba == now.rgba;
      } else {
        same = apart.root_mean_square <= renderer_distance.root_mean_square &&
               apart.blocks <= renderer_distance.blocks && std::abs(apart.mean) <= renderer_distance.mean &&
               apart.largest <= renderer_distance.largest;
      }
      if (!same) {
        fs::copy_file(scratch / "now.png", folder / (golden.name + ".new.png"), fs::copy_options::overwrite_existing);
      }
      CHECK(same);
    }
  }
}

TEST_CASE("what is allowed between renderers would not let another scale, a shift or a lost contact pass", "[golden]") {
  const Golden golden = goldens().front();
  const test::TemporaryFolder scratch;
  const Image whole = drawn(golden, scratch / "whole.png");

  Golden scaled = golden;
  scaled.spec.range = {{0, 1}};
  CHECK(distance(whole, drawn(scaled, scratch / "scaled.png")).root_mean_square > renderer_distance.root_mean_square);

  Image shifted = whole;
  std::rotate(shifted.rgba.begin(), shifted.rgba.end() - 4, shifted.rgba.end());  // by one pixel
  CHECK(distance(whole, shifted).root_mean_square > renderer_distance.root_mean_square);

  // The darkest pixel of the middle, which is part of a strong contact, and its neighbours turned to page.
  Image lost = whole;
  int at_x = 0, at_y = 0, darkest = 255;
  for (int y = whole.height / 4; y < whole.height / 2; ++y) {
    for (int x = whole.width / 4; x < whole.width / 2; ++x) {
      const int grey = whole.rgba[whole.offset(x, y)];
      if (grey < darkest) darkest = grey, at_x = x, at_y = y;
    }
  }
  for (int y = at_y - 1; y <= at_y + 1; ++y) {
    for (int x = at_x - 1; x <= at_x + 1; ++x)
      std::fill_n(lost.rgba.begin() + static_cast<long>(lost.offset(x, y)), 3, 255);
  }
  CHECK(distance(whole, lost).largest > renderer_distance.largest);
}

}  // namespace
}  // namespace granuscope
