#include "plot/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <utility>

#include "plot/plot_texts.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {
namespace {

/// A plot as wide as the text is made again this wide, for phones: two panels stand one above the other there.
constexpr double narrow_plot_width_inches = 0.5 * plot_width_inches;

/// gnuplot's point types; the last is a star.
constexpr std::array filled_markers = {7, 5, 13, 9, 11, 15, 3};

constexpr std::array<std::string_view, 8> plot_styles = {"filledcurves", "lines",       "points",      "linespoints",
                                                         "yerrorbars",   "xyerrorbars", "yerrorlines", "xyerrorlines"};

}  // namespace

Ink ink_of_series(std::size_t index) {
  constexpr std::array colours = {"blue", "bluish_green", "reddish_purple", "black", "sky_blue", "orange"};
  return {colours[index % colours.size()], filled_markers[index % filled_markers.size()]};
}

Ink ink_of_value(std::size_t index) {
  constexpr std::array colours = {"light_blue", "bright_blue", "blue", "deep_blue", "dark_blue"};
  return {colours[index % colours.size()], filled_markers[index % filled_markers.size()]};
}

void Panel::add_level(double y_value, const Style& style) {
  curves.insert(curves.begin(), {"", "", exact(y_value), x.low, x.high, style});
}

Panel left_panel() {
  Panel panel;
  panel.right = 0.485;
  return panel;
}

Panel right_panel() {
  Panel panel;
  panel.left = 0.6;
  panel.name = 0.513;
  return panel;
}

std::string Plot::add_data(const std::string& name, const CsvTable& table) {
  std::string file = id + (name.empty() ? "" : "-") + name + ".csv";
  data[file] = table.text();
  return file;
}

namespace {

Json to_json(const Style& style) {
  return {{"with", style.with}, {"colour", style.colour}, {"width", style.width},
          {"dash", style.dash}, {"marker", style.marker}, {"size", style.size}};
}

}  // namespace

Json axis_json(const Axis& axis) {
  Json ticks = Json::array();
  for (const Tick& tick : axis.ticks) ticks.push_back({{"label", tick.label}, {"at", tick.at}, {"minor", tick.minor}});
  return {{"label", axis.silent ? "" : axis.label},
          {"name", axis.label},
          {"low", axis.low},
          {"high", axis.high},
          {"log", axis.log},
          {"ticks", ticks}};
}

namespace {

Json to_json(const Panel& panel) {
  Json curves = Json::array(), texts = Json::array(), arrows = Json::array(), bands = Json::array();
  for (const Curve& curve : panel.curves) {
    Json one = curve.function.empty()
                   ? Json{{"file", curve.file}, {"columns", curve.columns}}
                   : Json{{"file", ""}, {"function", curve.function}, {"from", curve.from}, {"to", curve.to}};
    one["series"] = curve.series;
    one.update(to_json(curve.style));
    curves.push_back(one);
  }
  for (const PanelText& text : panel.texts) {
    texts.push_back(
        {{"text", text.text}, {"x", text.x}, {"y", text.y}, {"align", text.align}, {"colour", text.colour}});
  }
  for (const PanelArrow& arrow : panel.arrows) {
    Json one = {{"x", arrow.x},       {"y", arrow.y},       {"to_x", arrow.to_x},
                {"to_y", arrow.to_y}, {"x_in", arrow.x_in}, {"head", arrow.head}};
    one.update(to_json(arrow.style));
    arrows.push_back(one);
  }
  if (!panel.band.empty) bands.push_back({{"from", panel.band.low}, {"to", panel.band.high}});
  return {
      {"left", panel.left},      {"right", panel.right},
      {"top", panel.top},        {"bottom", panel.bottom},
      {"name", panel.name},      {"name_above", panel.name_above},
      {"x", axis_json(panel.x)}, {"y", axis_json(panel.y)},
      {"bands", bands},          {"texts", texts},
      {"arrows", arrows},        {"function_first", !panel.curves.empty() && !panel.curves.front().function.empty()},
      {"curves", curves}};
}

/// Panels that stand one above the other begin where the longest of their labels leaves room for it.
std::vector<Panel> with_room_for_labels(std::vector<Panel> panels) {
  std::vector<double> shifts;
  for (const Panel& panel : panels) {
    double shift = 0;
    for (const Panel& other : panels) {
      if (other.left == panel.left) shift = std::max(shift, room_for_labels(other.y.ticks, panel.left - panel.name));
    }
    shifts.push_back(panel.name_above ? 0 : shift);
  }
  for (std::size_t i = 0; i < panels.size(); ++i) panels[i].left += shifts[i];
  return panels;
}

/// What the key calls a curve's points, where the curve has no name of its own.
void name_series(std::vector<Panel>& panels, const PlotKey& key) {
  for (Panel& panel : panels) {
    for (Curve& curve : panel.curves) {
      const auto entry = std::ranges::find_if(key.entries, [&](const KeyEntry& one) {
        return one.style.colour == curve.style.colour && one.style.marker == curve.style.marker;
      });
      if (curve.series.empty() && entry != key.entries.end()) curve.series = entry->title;
    }
  }
}

Json to_json(const Plot& plot) {
  Json panels = Json::array(), entries = Json::array();
  std::vector<Panel> all = with_room_for_labels(plot.panels);
  name_series(all, plot.key);
  for (const Panel& panel : all) panels.push_back(to_json(panel));
  // Captions name panels by letters, since these stand side by side or one above the other. What shares its horizontal
  // axis with the panel below has none.
  const auto has_own_axis = [](const Panel& panel) { return !panel.x.silent; };
  if (std::ranges::count_if(all, has_own_axis) > 1) {
    char letter = 'a';
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (has_own_axis(all[i])) panels[i]["letter"] = fmt::format("({})", letter++);
    }
  }
  for (const KeyEntry& entry : plot.key.entries) {
    Json one = {{"title", entry.title}};
    one.update(to_json(entry.style));
    entries.push_back(one);
  }
  const PlotKey& key = plot.key;
  const bool halves =
      std::ranges::any_of(plot.panels, [](const Panel& panel) { return panel.left >= 0.5 || panel.right <= 0.5; });
  // Where they stand one above the other, the left ends of the panels on either side meet.
  const auto far = std::ranges::find_if(all, [](const Panel& panel) { return panel.left >= 0.5; });
  Json json = {{"height", plot.height},
               {"apart", far == all.end() ? 0.492 : far->left - all.front().left},
               {"half_width", plot.half_width},
               {"columns", halves ? 2 : 1},
               {"key",
                {{"inches", key.inches},
                 {"lines", key.lines},
                 {"horizontal", key.horizontal},
                 {"centred", key.centred},
                 {"sample", key.sample},
                 {"entries", entries}}},
               {"with_key", !key.entries.empty()},
               {"panels", panels}};
  json.update(plot.own);
  return json;
}

/// Fields that are no texts for a reader.
bool is_technical(std::string_view key) {
  constexpr std::array<std::string_view, 8> technical = {"file",   "columns", "function", "with",
                                                         "colour", "align",   "x_in",     "stem"};
  return std::ranges::find(technical, key) != technical.end();
}

/// Calls `see` with every text of the JSON and the key of the field in which it stands.
template <typename Any>
void each_text(Any& json, const std::string& key, const std::function<void(const std::string&, Any&)>& see) {
  if (json.is_string()) {
    see(key, json);
  } else if (json.is_object()) {
    for (auto it = json.begin(); it != json.end(); ++it) each_text<Any>(it.value(), it.key(), see);
  } else if (json.is_array()) {
    for (auto& one : json) each_text<Any>(one, key, see);
  }
}

/// gnuplot's words for what a field of a style says, and for the marks of an axis.
void add_words(Json& json, const TemplateVariables& colours) {
  if (json.is_array()) {
    for (Json& one : json) add_words(one, colours);
  }
  if (!json.is_object()) return;
  for (auto it = json.begin(); it != json.end(); ++it) add_words(it.value(), colours);
  if (json.contains("colour")) json["colour"] = colours.at(json["colour"].get<std::string>());
  if (json.contains("marker")) {
    std::string look;
    for (const auto& [field, word] :
         {std::pair{"marker", "pointtype"}, {"size", "pointsize"}, {"width", "linewidth"}, {"dash", "dashtype"}}) {
      const double number = json[field].get<double>();
      if (number > 0) look += fmt::format(" {} {}", word, exact(number));
    }
    look += fmt::format(" linecolor rgb '{}'", json["colour"].get<std::string>());
    json["look"] = look + (json.value("with", "") == "filledcurves" ? " fillstyle solid 0.45 noborder" : "");
  }
  if (json.contains("ticks")) {
    std::string list;
    for (const Json& tick : json["ticks"]) {
      list += fmt::format("{}{} {:.12g} {}", list.empty() ? "" : ", ", gnuplot_string(tick["label"].get<std::string>()),
                          tick["at"].get<double>(), tick["minor"].get<bool>() ? 1 : 0);
    }
    json["marks"] = list;
  }
}

int letters_of(const std::string& text) {
  return static_cast<int>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// The fields of a JSON object, and of those around it: a text between quotes that nothing inside can leave ({{x}}), or
/// as it stands ({{{x}}}).
class JsonScope : public TemplateScope {
 public:
  explicit JsonScope(const Json& here, const JsonScope* around = nullptr) : here_(here), around_(around) {}

  std::string text(const std::string& name) const override {
    const Json& value = at(name);
    return value.is_string() ? gnuplot_string(value.get<std::string>()) : raw_text(name);
  }

  std::string raw_text(const std::string& name) const override {
    const Json& value = at(name);
    if (value.is_string()) return value.get<std::string>();
    if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
    if (value.is_number()) return exact(value.get<double>());
    if (value.is_null()) return "NaN";
    throw std::logic_error(fmt::format("plot template: {} is neither a text nor a number", name));
  }

  void enter(const std::string& name, Missing missing, const Write& write) const override {
    const Json* value = find(name);
    if (value == nullptr && missing == Missing::is_an_error) at(name);
    if (value == nullptr || value->is_null() || *value == Json(false) || *value == Json("")) return;
    if (value->is_array()) {
      for (const Json& one : *value) write(JsonScope(one, this));
    } else if (value->is_object()) {
      write(JsonScope(*value, this));
    } else {
      write(*this);
    }
  }

 private:
  const Json* find(const std::string& name) const {
    if (name == ".") return &here_;
    const std::size_t dot = name.find('.');
    const std::string first = name.substr(0, dot);
    const bool known = here_.is_object() && here_.contains(first);
    if (!known) return around_ == nullptr ? nullptr : around_->find(name);
    return dot == std::string::npos ? &here_[first] : JsonScope(here_[first]).find(name.substr(dot + 1));
  }
  const Json& at(const std::string& name) const {
    const Json* value = find(name);
    if (value == nullptr) throw std::logic_error(fmt::format("plot template: there is no {{{{{}}}}}", name));
    return *value;
  }

  const Json& here_;
  const JsonScope* around_;
};

std::string own_script(const std::string& captions) {
  const std::string end = ".captions";
  return captions.substr(0, captions.size() - (captions.ends_with(end) ? end.size() : 0)) + ".gp.mustache";
}

}  // namespace

std::string fill_script(const FigureRecipe& recipe, std::string_view catalogue) {
  Json plot = recipe.plot;
  each_text<Json>(plot, "", [&](const std::string& key, Json& text) {
    if (is_technical(key)) return;
    std::string words = in_terms(text.get<std::string>(), recipe.wording.terms);
    for (const std::string_view phrases : {template_file("plot/labels.txt"), catalogue})
      words = in_terms(words, phrases);
    text = words;
  });
  int letters = 0;
  for (const Json& entry : plot.at("key").at("entries")) {
    letters = std::max(letters, letters_of(entry.at("title").get<std::string>()));
  }
  const TemplateVariables colours = plot_colours();
  add_words(plot, colours);
  const bool half = plot.at("half_width").get<bool>();
  plot.update({{"stem", recipe.id},
               {"width", plot_width_inches},
               {"own_width", half ? half_plot_width_inches : plot_width_inches},
               {"own_points", half ? 8 : 9},
               {"key_entries", plot["key"]["entries"].size()},
               {"key_letters", letters}});
  for (const auto& [name, colour] : colours) plot[name] = colour;
  const std::string own = own_script(recipe.wording.captions);
  return fill_template_file(has_template(own) ? own : "plot/figure.gp.mustache", JsonScope(plot));
}

namespace {

/// Puts the points of the run before, which lie beside as last-NAME.csv, in grey behind those of this one. Whether
/// there are any. Those beyond the axes are cut off.
bool add_last_run(Plot& plot, const std::filesystem::path& figures) {
  bool any = false;
  for (Panel& panel : plot.panels) {
    std::vector<Curve> curves;
    for (Curve curve : panel.curves) {
      const std::filesystem::path last = figures / ("last-" + curve.file);
      if (curve.style.size == 0 || !std::filesystem::is_regular_file(last)) continue;
      curve.file = std::string(behind) + curve.file;
      curve.style.colour = "frame";
      plot.data[curve.file] = read_file(last);
      curves.push_back(curve);
    }
    any = any || !curves.empty();
    panel.curves.insert(panel.curves.begin(), curves.begin(), curves.end());
  }
  return any;
}

/// Leaves out the curves of which no value is known: real numbers may all be lost in noise. False, and nothing left
/// out, where a panel would have none.
bool leave_out_unknown(Plot& of_this_run) {
  Plot plot = of_this_run;
  std::map<std::string, std::vector<std::string>> without;
  for (const auto& [file, csv] : plot.data) without[file] = columns_without_numbers(csv);
  for (Panel& panel : plot.panels) {
    std::erase_if(panel.curves, [&](const Curve& curve) {
      const std::size_t colon = curve.columns.find(':');
      if (!without.contains(curve.file) || colon == std::string::npos) return false;
      const auto column = static_cast<std::size_t>(std::atoi(curve.columns.c_str() + colon + 1));  // 0: a formula
      const std::vector<std::string>& names = without.at(curve.file);
      return column > 0 && column <= names.size() && !names[column - 1].empty();
    });
    if (panel.curves.empty()) return false;
  }
  of_this_run = std::move(plot);
  return true;
}

}  // namespace

Figure plot_figure(const Plot& given, const Wording& wording, const std::filesystem::path& run_folder) {
  const std::filesystem::path folder = "figures";
  Plot of_this_run = given;
  const bool some_may_lack = !has_template(own_script(wording.captions)) && leave_out_unknown(of_this_run);
  Plot plot = of_this_run;
  const bool with_last = add_last_run(plot, run_folder / folder);
  Figure figure;
  figure.id = plot.id;
  figure.redraw = fmt::format("cd figures && gnuplot -d {}.gp", plot.id);
  set_captions(figure, wording);
  if (with_last) figure.caption += fmt::format(" {}", behind_in_words);

  const FigureRecipe recipe{plot.id, to_json(plot), wording, figure.title, figure.caption};
  GnuplotJob job;
  job.stem = plot.id;
  job.script = fill_script(recipe);
  job.data = plot.data;
  for (auto& [name, csv] : job.data) {
    const std::size_t head = std::min(csv.find('\n'), csv.size());
    csv = in_terms(csv.substr(0, head), wording.terms) + csv.substr(head);
  }
  job.recipe = recipe_json(recipe);
  job.label = FileLabel{figure.title, figure.redraw, provenance_line(collect_provenance())};
  job.all_columns = !some_may_lack;
  job.curves = plot.other_curves;
  for (const Panel& panel : of_this_run.panels) job.curves += static_cast<int>(panel.curves.size());
  job.narrow_inches = plot.half_width ? 0 : narrow_plot_width_inches;
  try {
    plot_with_gnuplot(job, run_folder / folder);
  } catch (const EnvironmentError& failure) {
    figure.failure = failure.what();
    if (!is_drawn(job, run_folder / folder)) return figure;
  }
  figure.screen = folder / (plot.id + ".svg");
  if (job.narrow_inches > 0) figure.narrow = folder / narrow_svg(plot.id);
  figure.print = folder / (plot.id + ".pdf");
  figure.script = folder / (plot.id + ".gp");
  figure.recipe = folder / (plot.id + ".json");
  for (const auto& [name, csv] : plot.data) figure.data.push_back(folder / name);
  return figure;
}

namespace {

/// A text that stays one wherever it stands: gnuplot_string shuts it in, and TeX finds no command in it.
bool is_plain_text(std::string_view text) {
  return text.find_first_of("\"`\\@<") == std::string_view::npos &&
         text.substr(std::min(text.find_first_not_of(' '), text.size())).substr(0, 1) != "|" &&
         std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

/// Numbers, columns and what is calculated from them.
bool is_formula(std::string_view text) {
  std::string word;
  for (const char c : text) {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      word += c;
      continue;
    }
    if (!word.empty() && word != "e" && word != "exp" && word != "sqrt" && word != "NaN") return false;
    word.clear();
    if (std::isdigit(static_cast<unsigned char>(c)) == 0 &&
        std::string_view(" .:+-*/()$,?<>=").find(c) == std::string_view::npos)
      return false;
  }
  return word.empty();
}

bool is_file_name(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("._+-").find(c) != std::string_view::npos;
  });
}

bool is_harmless(const std::string& key, const std::string& text) {
  if (key == "file" || key == "stem") return is_file_name(text);
  if (key == "columns" || key == "function") return is_formula(text);
  if (key == "with") return std::ranges::find(plot_styles, text) != plot_styles.end();
  if (key == "colour") return plot_colours().contains(text);
  if (key == "align") return text == "left" || text == "right" || text == "center";
  if (key == "x_in") return text == "first" || text == "graph";
  // What a script makes of the fields itself.
  return key != "look" && key != "marks" && is_plain_text(text);
}

/// A recipe may come from anywhere, and gnuplot runs what is filled from it.
void require_harmless(const FigureRecipe& recipe, const std::string& source) {
  const auto refuse = [&source](const std::string& name, const std::string& text) {
    throw InputError(
        "{}: {} is \"{}\", which holds more than texts, numbers and curves, and gnuplot might run it as a command; run "
        "the experiment again",
        source, single_line(name), single_line(text.substr(0, 200)));
  };
  if (!is_file_name(recipe.id)) refuse("id", recipe.id);
  // Phrases take the place of others inside of quotes.
  if (recipe.wording.terms.find_first_of("'\"`\\@<|") != std::string::npos) refuse("terms", recipe.wording.terms);
  each_text<const Json>(recipe.plot, "", [&](const std::string& key, const Json& text) {
    if (!is_harmless(key, text.get<std::string>())) refuse(key, text.get<std::string>());
  });
  if (has_template(recipe.wording.captions)) return;
  throw InputError("{}: the program has no template {}; run the experiment again with this version", source,
                   single_line(recipe.wording.captions));
}

}  // namespace

std::string recipe_json(const FigureRecipe& recipe) {
  const Json json = {{"schema", 2},
                     {"id", recipe.id},
                     {"title", recipe.title},
                     {"caption", recipe.caption},
                     {"plot", recipe.plot},
                     {"captions",
                      {{"template", recipe.wording.captions},
                       {"variables", recipe.wording.variables},
                       {"terms", recipe.wording.terms}}}};
  return json.dump(1) + "\n";
}

FigureRecipe read_recipe(const std::string& json, const std::string& source) {
  FigureRecipe recipe;
  try {
    const Json read = Json::parse(shallow_json(json, source));
    read.at("id").get_to(recipe.id);
    read.at("title").get_to(recipe.title);
    read.at("caption").get_to(recipe.caption);
    recipe.plot = read.at("plot");
    read.at("captions").at("template").get_to(recipe.wording.captions);
    read.at("captions").at("variables").get_to(recipe.wording.variables);
    recipe.wording.terms = read.at("captions").value("terms", "");
  } catch (const Json::exception& error) {
    throw InputError(
        "{}: this is no recipe of a figure ({}), so that its script cannot be filled from other templates; run the "
        "experiment again",
        source, error.what());
  }
  require_harmless(recipe, source);
  return recipe;
}

}  // namespace granuscope
