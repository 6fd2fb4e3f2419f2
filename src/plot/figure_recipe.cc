#include <fmt/format.h>

#include <cctype>
#include <nlohmann/json.hpp>
#include <string>

#include "plot/plot_colours.h"
#include "plot/plot_script.h"
#include "support/error.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

/// Variables hold colours of the palette, too: each of `old` becomes the one of `now` of the same name.
void recolour(TemplateVariables& variables, const TemplateVariables& old, const TemplateVariables& now) {
  constexpr std::size_t length = 7;  // #rrggbb
  for (auto& [name, text] : variables) {
    for (std::size_t at = text.find('#'); at != std::string::npos; at = text.find('#', at + 1)) {
      for (const auto& [colour, hex] : old) {
        const auto other = now.find(colour);
        if (text.compare(at, length, hex) != 0 || other == now.end()) continue;
        text.replace(at, length, other->second);
        break;
      }
    }
  }
}

}  // namespace

std::string recipe_json(const FigureRecipe& recipe) {
  Json parts = Json::array();
  for (const ScriptPart& part : recipe.parts) {
    parts.push_back({{"template", part.script}, {"variables", part.variables}});
  }
  const Json json = {{"schema", 1},
                     {"id", recipe.id},
                     {"template", recipe.script},
                     {"title", recipe.title},
                     {"caption", recipe.caption},
                     {"height", recipe.height},
                     {"half_width", recipe.half_width},
                     {"variables", recipe.variables},
                     {"parts", parts},
                     {"captions",
                      {{"template", recipe.wording.captions},
                       {"variables", recipe.wording.variables},
                       {"terms", recipe.wording.terms}}},
                     {"colours", recipe.colours}};
  return json.dump(1) + "\n";
}

FigureRecipe read_recipe(const std::string& json, const std::string& source) {
  try {
    const Json read = Json::parse(json);
    FigureRecipe recipe;
    read.at("id").get_to(recipe.id);
    read.at("template").get_to(recipe.script);
    read.at("title").get_to(recipe.title);
    read.at("caption").get_to(recipe.caption);
    read.at("height").get_to(recipe.height);
    read.at("half_width").get_to(recipe.half_width);
    read.at("variables").get_to(recipe.variables);
    for (const Json& part : read.at("parts")) {
      recipe.parts.push_back({part.at("template"), part.at("variables").get<TemplateVariables>()});
    }
    read.at("captions").at("template").get_to(recipe.wording.captions);
    read.at("captions").at("variables").get_to(recipe.wording.variables);
    recipe.wording.terms = read.at("captions").value("terms", "");
    const auto old = read.at("colours").get<TemplateVariables>();
    recipe.colours = plot_colours();
    recolour(recipe.variables, old, recipe.colours);
    for (ScriptPart& part : recipe.parts) recolour(part.variables, old, recipe.colours);
    return recipe;
  } catch (const Json::exception& error) {
    throw InputError(fmt::format(
        "{}: this is no recipe of a figure ({}), so that its script cannot be filled from other templates; run the "
        "experiment again",
        source, error.what()));
  }
}

}  // namespace granuscope
