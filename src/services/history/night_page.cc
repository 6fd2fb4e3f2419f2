#include "history/night_book.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <system_error>

#include "history/nightly.h"
#include "pipeline/run_folder.h"
#include "report/clean_json.h"
#include "report/page_scope.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/progress.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {
namespace {
constexpr std::size_t nights_in_trends = 365, nights_in_table = 100;
constexpr double width = 720, height = 120, margin = 9;  // of a trend, in its own units

std::string day_of(const Night& night) { return night.date.substr(0, night.date.find('T')); }

std::string named(const Night& night) { return fmt::format("night {}, {}", night.number, day_of(night)); }

/// "c at μ = 0.3" for c at mu = 0.3, and β for beta.
std::string in_symbols(std::string name) {
  for (const auto& [word, symbol] : {std::pair("mu =", "μ ="), {"alpha", "α"}, {"beta", "β"}, {"gamma", "γ"}}) {
    if (const std::size_t at = name.find(word); at != std::string::npos)
      name.replace(at, std::string_view(word).size(), symbol);
  }
  return name;
}

/// The program of a night as its environment has it; empty if it does not.
std::string program_of(const Night& night) {
  const auto program = night.environment.find("program"), commit = night.environment.find("git_commit");
  std::string words = program == night.environment.end() ? "" : program->second;
  if (commit != night.environment.end())
    words += (words.empty() ? "commit " : ", commit ") + commit->second.substr(0, 10);
  return words;
}

bool was_told(const Alarm& alarm) { return alarm.state == "open" || alarm.state == "passed"; }

template <class Item, class Is>
const Item* find(const std::vector<Item>& items, Is is) {
  const auto found = std::ranges::find_if(items, is);
  return found == items.end() ? nullptr : &*found;
}

const NightVerdict* verdict_of(const Night& night, const std::string& claim) {
  return find(night.verdicts, [&](const NightVerdict& one) { return one.claim == claim; });
}

bool alarms(const Night& night) { return std::ranges::any_of(night.alarms, was_told); }

}  // namespace

void to_json(Json& json, const Alarm& one) { json = {{"kind", one.kind}, {"what", one.what}, {"state", one.state}}; }

void to_json(Json& json, const NightVerdict& one) {
  json = {{"claim", one.claim}, {"verdict", one.verdict}, {"z", finite_or_null(one.z)}};
}

void to_json(Json& json, const NightNumber& one) {
  json = {{"name", one.name},
          {"value", one.pool.value},
          {"stderr", one.pool.standard_error},
          {"piece", finite_or_null(one.piece)},
          {"piece_stderr", finite_or_null(one.piece_error)},
          {"z", finite_or_null(one.z)},
          {"moved", one.moved}};
}

namespace {

/// A quantity over the nights; NaN where a night has none.
struct Trend {
  std::string name, last;
  std::vector<double> value, error;

  std::string text(std::size_t i) const {
    return error[i] > 0 ? value_with_error(value[i], error[i]) : significant(value[i], 3);
  }
};

struct Scale {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double number) {
    if (!std::isfinite(number)) return;
    low = std::min(low, number);
    high = std::max(high, number);
  }
  double place(double number) const {
    return high > low ? height - margin - (number - low) / (high - low) * (height - 2 * margin) : height / 2;
  }
};

double place_of(std::size_t i, std::size_t nights) {
  return nights < 2 ? width / 2
                    : margin + static_cast<double>(i) / static_cast<double>(nights - 1) * (width - 2 * margin);
}

Json drawn(const Trend& trend, const std::vector<Night>& nights, const Json& marks) {
  Scale scale;
  for (std::size_t i = 0; i < trend.value.size(); ++i) {
    scale.add(trend.value[i] - trend.error[i]);
    scale.add(trend.value[i] + trend.error[i]);
  }
  std::string line, upper, lower;
  Json points = Json::array();
  for (std::size_t i = 0; i < trend.value.size(); ++i) {
    if (!std::isfinite(trend.value[i])) continue;
    const double x = place_of(i, trend.value.size());
    const auto point = [&](double value) { return fmt::format("{:.1f},{:.1f} ", x, scale.place(value)); };
    line += point(trend.value[i]);
    upper += point(trend.value[i] + trend.error[i]);
    lower.insert(0, point(trend.value[i] - trend.error[i]));
    points.push_back({{"x", fmt::format("{:.1f}", x)},
                      {"y", fmt::format("{:.1f}", scale.place(trend.value[i]))},
                      {"text", fmt::format("{}, {} samples: {}", named(nights[i]), nights[i].samples, trend.text(i))}});
  }
  // With as many places as tell the ends of the scale apart.
  const double size = scale.high - scale.low;
  const int places = size > 0 ? std::max(0, 1 - static_cast<int>(std::floor(std::log10(size)))) : 3;
  return {{"name", in_symbols(trend.name)},
          {"points", points},
          {"radius", nights.size() > 60 ? "3" : "6"},
          {"last", trend.last},
          {"line", line},
          {"band", upper + lower},
          {"low", fmt::format("{:.{}f}", scale.low, places)},
          {"high", fmt::format("{:.{}f}", scale.high, places)},
          {"marks", marks}};
}

/// What changed in the environment from one night to the next, in words; empty if nothing.
std::string change_between(const Night& before, const Night& now) {
  std::vector<std::string> changes;
  for (const auto& [name, value] : now.environment) {
    const auto then = before.environment.find(name);
    if (then != before.environment.end() && then->second != value) {
      changes.push_back(fmt::format("{} {} → {}", name, then->second, value));
    }
  }
  return fmt::format("{}", fmt::join(changes, ", "));
}

/// Of nights whose program, libraries or processor are others than the night before.
Json marks_of(const std::vector<Night>& nights) {
  Json marks = Json::array();
  for (std::size_t i = 1; i < nights.size(); ++i) {
    const std::string change = change_between(nights[i - 1], nights[i]);
    if (change.empty()) continue;
    marks.push_back({{"x", fmt::format("{:.1f}", place_of(i, nights.size()))},
                     {"change", fmt::format("{}: {}", day_of(nights[i]), change)}});
  }
  return marks;
}

std::vector<Trend> number_trends(const std::vector<Night>& nights) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<Trend> trends;
  for (std::size_t i = 0; i < nights.size(); ++i) {
    for (const NightNumber& number : nights[i].numbers) {
      auto trend = std::ranges::find_if(trends, [&](const Trend& one) { return one.name == number.name; });
      if (trend == trends.end()) {
        const std::vector<double> none(nights.size(), unknown);
        trend = trends.insert(trends.end(), {number.name, "", none, none});
      }
      trend->value[i] = number.pool.value;
      trend->error[i] = number.pool.standard_error;
      trend->last = value_with_error(number.pool.value, number.pool.standard_error);
    }
  }
  // What there is no more keeps its past, behind those that there are.
  const auto tells =
      std::find_if(nights.rbegin(), nights.rend(), [](const Night& one) { return !one.numbers.empty(); });
  if (tells != nights.rend()) {
    const auto last = static_cast<std::size_t>(nights.rend() - tells) - 1;
    for (Trend& trend : trends) {
      if (!std::isnan(trend.value[last])) continue;
      std::size_t of = last;
      while (std::isnan(trend.value[of])) --of;
      trend.last += fmt::format(" on {}, none since", day_of(nights[of]));
    }
    std::stable_partition(trends.begin(), trends.end(),
                          [last](const Trend& trend) { return !std::isnan(trend.value[last]); });
  }
  // What is exact, and has been so on every night, is no trend.
  std::erase_if(trends, [](const Trend& trend) {
    const bool exact_each_night = std::ranges::all_of(trend.error, [](double e) { return !(e > 0); });
    const auto first = std::ranges::find_if(trend.value, [](double v) { return std::isfinite(v); });
    return exact_each_night && std::ranges::all_of(trend.value, [&](double v) { return std::isnan(v) || v == *first; });
  });
  return trends;
}

std::vector<Trend> time_trends(const std::vector<Night>& nights) {
  std::vector<Trend> trends;
  for (const char* what : {"canary", "pool"}) {
    Trend trend{what, "", {}, {}};
    for (const Night& night : nights) {
      const auto found = night.seconds.find(what);
      trend.value.push_back(found == night.seconds.end() ? std::nan("") : found->second);
      trend.error.push_back(0);
      if (found != night.seconds.end()) trend.last = describe_duration(found->second);
    }
    trends.push_back(std::move(trend));
  }
  return trends;
}

/// "c-of-mu: not decided → reproduced", of claims whose verdict was another one the night before.
std::string changed_claims(const Night* before, const Night& now) {
  std::vector<std::string> changed;
  for (const NightVerdict& one : now.verdicts) {
    const NightVerdict* then = before == nullptr ? nullptr : verdict_of(*before, one.claim);
    if (then != nullptr && then->verdict != one.verdict)
      changed.push_back(fmt::format("{}: {} → {}", one.claim, then->verdict, one.verdict));
  }
  return fmt::format("{}", fmt::join(changed, "; "));
}

Json row_of(const Night& night, const Night* before, const std::set<std::string>& kept) {
  std::map<std::string, int> verdicts;
  for (const NightVerdict& one : night.verdicts) ++verdicts[one.verdict];
  std::vector<std::string> counted;
  counted.reserve(verdicts.size());
  for (const auto& [verdict, count] : verdicts) counted.push_back(fmt::format("{} {}", count, verdict));
  const std::string report = kept.contains(night.report) ? night.report : "";
  return {{"night", std::to_string(night.number)},
          {"date", day_of(night)},
          {"samples", std::to_string(night.samples)},
          {"status", alarms(night) ? "alarm" : "fine"},
          {"look", alarms(night) ? "no" : "yes"},
          {"verdicts", fmt::format("{}", fmt::join(counted, ", "))},
          {"changed", changed_claims(before, night)},
          {"alarms", night.alarms},
          {"report", report},
          {"has_report", !report.empty()}};
}

std::set<std::string> reports_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const fs::path& entry : entries_of(folder / "reports")) names.insert(entry.filename());
  return names;
}

std::string badge(const Night& last) {
  const Json json = {{"schemaVersion", 1},
                     {"label", "granuscope nightly"},
                     {"message", alarms(last) ? fmt::format("alarm on {}", day_of(last))
                                              : fmt::format("fine on {}, {} samples", day_of(last), last.samples)},
                     {"color", alarms(last) ? "critical" : "success"}};
  return json.dump(2) + "\n";
}

/// A link appears whole, too. Where the file system has none, copies take its place; so do they in a copy of a history,
/// where they are those of an older night, or a text that names the folder, as zip and git leave it.
void point_latest_to(const fs::path& folder, const std::string& report) {
  const fs::path target = fs::path("reports") / report, link = folder / "latest",
                 beside = folder / scratch_name("latest");
  std::error_code error;
  if (fs::is_regular_file(fs::symlink_status(link, error))) {
    if (!read_file(link).starts_with("reports/"))
      throw EnvironmentError("'{}' is a file where a link to the last report stands; move it away", link.string());
    remove_if_there(link);
  }
  fs::create_directory_symlink(target, beside, error);
  if (error) fs::copy(folder / target, beside, fs::copy_options::recursive, error);
  if (!error && fs::is_directory(fs::symlink_status(link))) remove_run(link);
  if (!error) fs::rename(beside, link, error);
  if (error) {
    throw EnvironmentError("'{}' cannot be made to point to the last report: {}; remove what is there", link.string(),
                           error.message());
  }
}

}  // namespace

std::string describe(const Night& night) {
  std::string text = fmt::format("{} {} {}, {} samples", night.number, single_line(night.date),
                                 alarms(night) ? "alarm" : "fine", night.samples);
  for (const Alarm& alarm : night.alarms) {
    const std::string line = fmt::format("{} ({}): {}", alarm.kind, alarm.state, alarm.what);
    text += "\n  " + single_line(line, line.size());
  }
  return text;
}

void write_pages(const fs::path& folder, const NightBook& book) {
  const std::vector<Night> nights = book.last(nights_in_trends);
  if (nights.empty()) {
    for (const char* page : {"index.html", "badge.json", "alert.md"}) remove_if_there(folder / page);
    return;
  }
  const Json marks = marks_of(nights);
  std::set<std::string> kept = reports_in(folder);
  std::erase_if(kept, [&](const std::string& name) { return !fs::exists(folder / "reports" / name / "report.html"); });
  Json numbers = Json::array(), times = Json::array(), rows = Json::array(), changes = Json::array();
  for (const Trend& trend : number_trends(nights)) numbers.push_back(drawn(trend, nights, marks));
  for (const Trend& trend : time_trends(nights)) times.push_back(drawn(trend, nights, marks));
  for (std::size_t i = nights.size(); i > 0 && rows.size() < nights_in_table; --i)
    rows.push_back(row_of(nights[i - 1], i > 1 ? &nights[i - 2] : nullptr, kept));
  const Night& last = nights.back();
  const auto latest =
      std::find_if(nights.rbegin(), nights.rend(), [&](const Night& one) { return kept.contains(one.report); });
  const Json overlay = {{"style", template_file("screen.css")},
                        {"numbers", numbers},
                        {"times", times},
                        {"changes", marks},
                        {"has_changes", !marks.empty()},
                        {"nights", rows},
                        {"count", std::to_string(book.count())},
                        {"first", named(nights.front())},
                        {"to", named(last)},
                        {"program", program_of(last)},
                        {"last", row_of(last, nights.size() > 1 ? &nights[nights.size() - 2] : nullptr, kept)},
                        {"has_alarms", alarms(last)},
                        {"has_latest", latest != nights.rend()}};
  const Json summary = Json::object();
  write_file(folder / "index.html",
             fill_template_file("history/index.html.mustache", PageScope(summary, overlay, Markup::html)));
  write_file(folder / "badge.json", badge(last));
  if (alarms(last)) {
    write_file(folder / "alert.md",
               fill_template_file("history/alert.md.mustache", PageScope(summary, overlay, Markup::markdown)));
  } else {
    remove_if_there(folder / "alert.md");
  }
  if (latest != nights.rend()) point_latest_to(folder, latest->report);  // last: the one thing that may be in the way
}

void tell_not_run(const fs::path& folder) {
  const fs::path file = folder / "badge.json";
  // What somebody else calls so stays as it is.
  if (fs::is_symlink(file) || !file_exists(file) || read_file(file).find("granuscope nightly") == std::string::npos)
    return;
  const Json json = {{"schemaVersion", 1},
                     {"label", "granuscope nightly"},
                     {"message", fmt::format("not run on {}", current_time().substr(0, 10))},
                     {"color", "critical"}};
  write_file(file, json.dump(2) + "\n");
}

void prune_reports(const fs::path& folder, const NightBook& book, std::size_t keep) {
  const std::set<std::string> kept = book.last_reports(std::max<std::size_t>(1, keep));
  for (const std::string& report : reports_in(folder)) {
    // Folders that nights have left have the day as their name, and a number if there were more on that day.
    const bool of_night = report.size() >= 10 && report.find_first_not_of("0123456789-") == std::string::npos;
    if (!of_night || kept.contains(report)) continue;
    try {
      remove_run(folder / "reports" / report);
    } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): somebody keeps files there, and they stay
    }
  }
}

std::string json_text(const std::vector<Night>& nights) {
  Json list = Json::array();
  for (const Night& night : nights) {
    Json one = {{"night", night.number},     {"date", night.date},       {"status", alarms(night) ? "alarm" : "fine"},
                {"samples", night.samples},  {"report", night.report},   {"environment", night.environment},
                {"seconds", Json::object()}, {"numbers", night.numbers}, {"verdicts", night.verdicts},
                {"alarms", night.alarms}};
    for (const auto& [stage, seconds] : night.seconds) one["seconds"][stage] = finite_or_null(seconds);
    list.push_back(std::move(one));
  }
  Json json = {{"schema", 1}, {"nights", list}};
  clean_strings(json);
  return json.dump(2) + "\n";
}

std::string table_text(const Night& night) {
  const auto text = [](double value, double error) {
    return std::isfinite(value) ? value_with_error(value, error) : std::string("–");
  };
  std::string table = describe(night) + "\n\nnumber\tall piles\tof this night\tz\n";
  for (const NightNumber& one : night.numbers) {
    table += fmt::format("{}\t{}\t{}\t{}{}\n", one.name, text(one.pool.value, one.pool.standard_error),
                         text(one.piece, one.piece_error), std::isfinite(one.z) ? significant(one.z, 2) : "–",
                         one.moved ? ", moved" : "");
  }
  table += "\nclaim\tverdict\n";
  for (const NightVerdict& one : night.verdicts) table += fmt::format("{}\t{}\n", one.claim, one.verdict);
  if (!night.report.empty()) table += "\nreport: reports/" + single_line(night.report) + "/report.html\n";
  return aligned(table);
}

std::string csv_text(const std::vector<Night>& nights) {
  const auto cell = [](double number) { return std::isfinite(number) ? exact(number) : ""; };
  CsvTable table({"night", "date", "status", "samples", "name", "value", "stderr", "piece", "piece_stderr", "z"});
  for (const Night& night : nights) {
    for (const NightNumber& number : night.numbers) {
      table.add_cells({std::to_string(night.number), night.date, alarms(night) ? "alarm" : "fine",
                       std::to_string(night.samples), number.name, cell(number.pool.value),
                       cell(number.pool.standard_error), cell(number.piece), cell(number.piece_error), cell(number.z)});
    }
  }
  return table.text();
}

namespace {

constexpr double edge = 3, edge_width = 1;  // standard errors

/// A growing pool decides more and more; only from one decision to the other is a change of what was found.
bool decides(const NightVerdict& one) {
  return (one.verdict == "reproduced" || one.verdict == "not reproduced") && !at_the_edge(one.z);
}

/// What the nights before, but for the last `skipped` ones, had decided; null if nothing.
const NightVerdict* last_decided(const std::vector<Night>& before, const std::string& claim, std::size_t skipped) {
  for (std::size_t i = before.size(); i > skipped; --i) {
    const NightVerdict* one = verdict_of(before[i - 1 - skipped], claim);
    if (one != nullptr && decides(*one)) return one;
  }
  return nullptr;
}

}  // namespace

bool at_the_edge(double z) { return std::isfinite(z) && std::abs(std::abs(z) - edge) <= edge_width; }

void add_soft_alarms(Night& tonight, const std::vector<Night>& before) {
  const Night* last = before.empty() ? nullptr : &before.back();
  for (const NightNumber& number : tonight.numbers) {
    if (!number.moved) continue;
    const NightNumber* then =
        last == nullptr ? nullptr
                        : find(last->numbers, [&](const NightNumber& one) { return one.name == number.name; });
    const bool again = then != nullptr && then->moved;
    tonight.alarms.push_back(
        {"number",
         fmt::format("{} of tonight's piles is {}, {} standard errors from the pool's {}{}", number.name,
                     value_with_error(number.piece, number.piece_error), significant(number.z, 2),
                     value_with_error(number.pool.value, number.pool.standard_error),
                     again ? "; it moved the night before, too" : ""),
         again ? "open" : "watched"});
  }
  for (const NightVerdict& now : tonight.verdicts) {
    if (!decides(now)) continue;
    const NightVerdict* then = last == nullptr ? nullptr : verdict_of(*last, now.claim);
    const NightVerdict* settled =
        last_decided(before, now.claim, then == nullptr || then->verdict != now.verdict ? 0 : 1);
    if (settled == nullptr || settled->verdict == now.verdict) continue;
    const bool again = then != nullptr && then->verdict == now.verdict && decides(*then);
    tonight.alarms.push_back({"verdict",
                              fmt::format("{}: {}{} where it was {}", now.claim, now.verdict,
                                          again ? " for two nights now" : "", settled->verdict),
                              again ? "open" : "watched"});
  }
}

}  // namespace granuscope
