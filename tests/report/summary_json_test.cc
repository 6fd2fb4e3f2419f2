#include "report/summary_json.h"

#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/synthetic_analysis.h"
#include "report/fixture.h"
#include "report/report.h"
#include "report/run_files.h"
#include "support/files.h"

using namespace granuscope;
using Json = nlohmann::ordered_json;
using test::contains;

namespace {

ReportData numbers_only() {
  ReportData data;
  data.experiment_name = "quick";
  data.columns = 500;
  data.layers = 200;
  data.seed = 18446744073709551615ULL;
  data.analysis = synthetic::analysis();
  data.provenance.host_cpu = "secret-host";
  data.environment = {{"gnuplot", "secret-version"}};
  return data;
}

}  // namespace

TEST_CASE("The summary has the fields others rely on") {
  const std::string text = summary_json(numbers_only());
  const Json json = Json::parse(text);
  CHECK(text.starts_with("{\n  \"schema\": 5,\n  \"experiment\": \"quick\","));
  CHECK(json["seed"] == 18446744073709551615ULL);
  const Json& result = json["results"][4];
  CHECK(result["mu"] == 0.3);
  CHECK(result["law"] == "granusolve");
  CHECK(result["estimator"] == "point");
  CHECK(result["samples"] == 3455);
  CHECK(result["failed"][0]["sample"] == 17);
  CHECK(result["failed"][0]["layer"] == 40);
  CHECK(contains(result["failed"][0]["replay"], "granuscope sample"));
  CHECK(result["c"] == Json{{"value", 0.56}, {"stderr", 0.001}});
  CHECK(result["D"]["stderr"] == 0.005);
  CHECK(result["alpha_thrust"]["stderr"] == 2.1e-5);
  CHECK(result["c_thrust"]["value"] == 0.556);
  CHECK(result["sampler"]["draws_per_bead"] == 1.4023);
  CHECK(result["sampler"]["repaired_per_bead"] == 0.1304);
  CHECK(result["sampler"]["backtracked_per_bead"] == 0.0016);
  for (const char* key : {"layer", "z", "peak_position", "width", "chi2_per_dof", "identifiable"}) {
    CHECK(result["depths"][10].contains(key));
  }
  // What c and D mean is told beside the shifts under the other weights.
  CHECK(json["weights"]["modes"] == "exp(-k^2 (W^2 + 1)/4)");
  CHECK(json["weights"]["depths"] == "1/z^2");
  CHECK(json["weights"]["varied_to"]["modes"] == "equal");
  CHECK(json["scaling"]["beta"]["value"] == 2.538);
  CHECK(json["scaling"]["beta"]["window"] == Json{0.1, 0.3});
  CHECK(json["scaling"].contains("gamma"));
  CHECK(json["scaling"].contains("alpha"));
  const Json& claim = json["claims"][1];
  CHECK(claim["id"] == "D-of-mu");
  CHECK(claim["verdict"] == "reproduced");
  CHECK(claim["expected"] == "reproduced");
  CHECK(claim["measured"] == 2.538);
  CHECK(claim["stderr"] == 0.081);
  CHECK(claim["paper"] == 2.5);
  CHECK(claim["z_score"] == 0.4);
}

TEST_CASE("Unknown numbers are null beside a reason, and nothing is NaN") {
  ReportData data = numbers_only();
  data.analysis.results[1].depths[0].chi2_per_dof = std::numeric_limits<double>::quiet_NaN();
  data.analysis.results[1].c.standard_error = std::numeric_limits<double>::infinity();
  data.analysis.results[2].c = Estimate{};  // unknown without a reason
  data.analysis.claims[1].z_score = std::numeric_limits<double>::infinity();
  const std::string text = summary_json(data);
  CHECK_FALSE(contains(text, "nan"));
  CHECK_FALSE(contains(text, "NaN"));
  CHECK_FALSE(contains(text, "inf"));
  const Json json = Json::parse(text);
  CHECK(json["results"][6]["D"]["value"].is_null());
  CHECK(json["results"][6]["D"]["reason"] == "the widths at 7 of 41 depths are not identified");
  CHECK(json["results"][1]["c"]["stderr"].is_null());
  CHECK(json["results"][1]["c"].contains("reason"));
  CHECK(json["results"][2]["c"].contains("reason"));
  CHECK(json["claims"][1]["z_score"].is_null());
  CHECK(json["claims"][1].contains("reason"));
  CHECK(json["claims"][4]["measured"].is_null());
  CHECK(json["claims"][4]["paper"].is_null());
  CHECK(json["claims"][4]["reason"] == "no claim about heights is evaluated with fewer than eight depths");
  CHECK(json["claims"][4]["expected"].is_null());
}

TEST_CASE("The summary knows no time, host or path, and hostile names do not break it") {
  ReportData data = numbers_only();
  data.experiment_name = synthetic::hostile_text();
  data.timings = {{"secret-stage", 12.5, false}};
  const std::string text = summary_json(data);
  CHECK_FALSE(contains(text, "secret"));
  CHECK(text == summary_json(data));
  CHECK(contains(Json::parse(text)["experiment"], "<script>alert(1)</script> {{x}}"));
  CHECK(contains(Json::parse(text)["experiment"], "\xEF\xBF\xBD"));
}

TEST_CASE("The manifest lists every file with its hash, also of a failed run") {
  const test::TemporaryFolder run;
  write_file(run.path() / "summary.json", "{}");
  make_folder(run.path() / "figures");
  write_file(run.path() / "figures" / "a.csv", "x\n1\n");
  write_file(run.path() / ".hidden", "temporary");
  write_file(run.path() / "figures" / ".hidden", "temporary");
  // What a user keeps in the folder is none of a manifest's that may be passed on.
  write_file(run.path() / "thesis.tex", "private");
  make_folder(run.path() / "letters");
  write_file(run.path() / "letters" / "a.txt", "private");
  RunOutcome outcome;
  outcome.status = "failed";
  outcome.exit_code = 3;
  outcome.error = synthetic::hostile_text();
  write_manifest(numbers_only(), run.path(), outcome);
  write_manifest(numbers_only(), run.path(), outcome);  // the first one is not listed in the second
  const Json json = Json::parse(read_file(run.path() / "manifest.json"));
  CHECK(json["status"] == "failed");
  CHECK(json["exit_code"] == 3);
  CHECK(contains(json["error"], "<script>"));
  REQUIRE(json["files"].size() == 3);
  CHECK(json["files"][0]["path"] == "figures/a.csv");
  CHECK(json["files"][0]["bytes"] == 4);
  CHECK(json["files"][1]["path"] == "summary.json");
  // `printf '{}' | sha256sum`
  CHECK(json["files"][1]["sha256"] == "44136fa355b3678a1146ad16f7e8649e94fb4fc21fe77e8310c060f61caaff8a");
  CHECK(json["provenance"]["host_cpu"] == "secret-host");
  CHECK_NOTHROW(manifest_json({}, run.path() / "no-such-folder", {}));
}

TEST_CASE("A JUnit case fails only when its verdict is not the expected one") {
  std::vector<Claim> claims = synthetic::claims();
  claims[0].verdict = "not reproduced";
  claims[0].explanation = "a < b & c";
  const std::string xml = junit_claims(claims, synthetic::hostile_text());
  CHECK(contains(xml, "tests=\"5\" failures=\"1\" errors=\"0\" skipped=\"1\""));
  CHECK(contains(xml,
                 "name=\"frictionless\"><failure message=\"the verdict is not reproduced, expected was "
                 "reproduced\">a &lt; b &amp; c</failure><system-out>not reproduced: "));
  CHECK(contains(xml, "name=\"c-of-mu\"><system-out>not reproduced: "));  // expected: no failure
  CHECK(contains(xml,
                 "name=\"amplitude\"><skipped message=\"not tested\"/><system-out>not tested: "));  // no expectation:
                                                                                                    // no failure
  CHECK_FALSE(contains(xml, "<script>"));
}

TEST_CASE("The Markdown summary has the numbers, and user text stays text") {
  ReportData data = numbers_only();
  data.experiment_name = synthetic::hostile_text();
  const std::string text = markdown_summary(data, nlohmann::ordered_json::parse(summary_json(data)));
  CHECK(contains(text, "| D ∝ μᵝ | 2.538(81) | ≈ 2.5 | 0.1 – 0.3 | reproduced |"));
  CHECK(contains(text, "| 0.3 | 0.5600(10) | 0.0780(50) |"));
  CHECK(contains(text, "| 0.6 | 0.5371(44) | n/a |"));
  CHECK_FALSE(contains(text, "<script>"));
  CHECK_FALSE(contains(text, "`rm -rf /`"));
  CHECK(contains(text, "\\`rm -rf /\\`"));
  CHECK(text.substr(0, text.find('\n')).find("second line") != std::string::npos);  // one line
}
