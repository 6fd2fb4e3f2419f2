#include "studies/spreading.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "analysis/claims.h"
#include "analysis/linear_model.h"
#include "ensemble/ensemble_runner.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "studies/study_page.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using test::contains;
using test::TemporaryFolder;

namespace {

/// The ensemble of a study that follows three octaves at mu = 0.3.
struct Asked {
  std::unique_ptr<Study> study = deep_response_study();
  MainLine main;

  void set(const std::string& name, const KeyValue& value) {
    for (const Key& key : study->keys()) {
      if (key.name == name) key.set(value);
    }
  }
  explicit Asked(std::int64_t columns) {
    set("mu", std::vector<double>{0.3});
    set("octaves", std::int64_t{3});
    set("columns", columns);
    set("samples", std::int64_t{256});
  }
};

}  // namespace

TEST_CASE("The deep response is followed over lags that double, and its slopes and exponents belong to them",
          "[unsanitized]") {
  Asked asked(320);
  REQUIRE_FALSE(asked.study->find_problem(asked.main));
  const std::vector<StudyEnsemble> ensembles = asked.study->ensembles(asked.main);
  REQUIRE(ensembles.size() == 1);
  const EnsembleSpec& spec = ensembles[0].spec;
  CHECK(spec.layers == std::vector<int>{32, 64, 128, 256});
  const MeasuredEnsemble ensemble{spec, run_ensemble(spec, 0, nullptr)};
  const DeepResponse response = measure_spreading(ensemble, DeepMeasurement::fluctuations, 2);
  REQUIRE(response.lags.size() == 4);
  REQUIRE(response.octaves.size() == 3);
  CHECK(response.samples == 256);
  for (std::size_t i = 0; i < 3; ++i) {
    const LagResponse &above = response.lags[i], &below = response.lags[i + 1];
    const OctaveOfDepth& octave = response.octaves[i];
    REQUIRE(octave.exponent.known());
    CHECK(below.z == Approx(2 * above.z));
    CHECK(above.z == Approx(above.lag * std::sqrt(3) / 2));
    CHECK(octave.exponent.value ==
          Approx(std::log2(below.width_squared.value / above.width_squared.value)).epsilon(1e-12));
    CHECK(octave.c.value ==
          Approx((below.peak_position.value - above.peak_position.value) / (below.z - above.z)).epsilon(1e-12));
    CHECK(octave.D.value ==
          Approx((below.width_squared.value - above.width_squared.value) / (below.z - above.z)).epsilon(1e-12));
    CHECK(octave.c_minus_c_thrust.value == Approx(octave.c.value - response.c_thrust.value).margin(1e-12));
    // A background has one number more, so that it never fits worse; these peaks have hardly any.
    CHECK(below.chi2_beside_per_dof > 0);
    CHECK(below.between.standard_error > 0);
    CHECK(std::abs(below.between.value) < 5 * below.between.standard_error + 0.05);
    CHECK(octave.between.value == below.between.value);
    CHECK(std::abs(octave.c_beside.value - octave.c.value) < 5 * octave.c_beside.standard_error + 0.002);
    // Independent errors would be larger than this only if the two lags were anticorrelated.
    CHECK(octave.exponent.standard_error > 0);
    CHECK(std::abs(octave.exponent.value - 1.07) < 5 * octave.exponent.standard_error + 0.05);
    CHECK(std::abs(octave.c.value - 0.5575) < 5 * octave.c.standard_error + 0.001);
  }
  CHECK(response.c_thrust.value == Approx(0.5557).margin(0.0005));

  asked.study->begin(asked.main, 2);
  asked.study->add(ensembles[0], ensemble);
  asked.study->finish();
  const auto json = asked.study->json();
  REQUIRE(json.size() == 1);
  CHECK(json[0].at("octaves").size() == 3);
  CHECK(json[0].at("lags")[3].at("lag") == 256);
  CHECK(json[0].at("octaves")[1].at("exponent").at("value") == response.octaves[1].exponent.value);
  CHECK(json[0].at("base_layers")[0] == 60);
  const Page page = study_page(*asked.study);
  CHECK(contains(page.html, "from one depth to twice that depth"));
  CHECK(page.texts.at("/studies/deep_response/0/octaves/0/z/0") == "28");
  CHECK(page.texts.at("/studies/deep_response/0/octaves/0/z/1") == "55");
  CHECK(page.texts.contains("/studies/deep_response/0/octaves/2/c_minus_c_thrust"));
  CHECK(page.texts.contains("/studies/deep_response/0/octaves/2/between"));
  CHECK(json[0].at("lags")[3].at("between").at("value") == response.lags[3].between.value);

  const TemporaryFolder run;
  const Figure figure = plot_deep_response({response}, run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(figure.data.size() == 1);
  CHECK(contains(figure.details, "256 uniformly loaded piles"));
  CHECK(contains(figure.details, "z = 222"));
  CHECK(contains(read_file(run.path() / figure.screen), "power of z in W²"));
  CHECK(response.shallow.exponent.value == response.octaves[1].exponent.value);
  CHECK(response.deep.exponent.value == response.octaves[2].exponent.value);
  REQUIRE(response.bands.size() > 5);
  for (std::size_t i = 0; i < response.bands.size(); ++i) {
    const BandOfModes& band = response.bands[i];
    if (i > 0) CHECK(band.k > response.bands[i - 1].k);
    // Small k are still far from saturated so near to the top, and the noise of one mode alone is not Gaussian.
    if (band.modes < 4) continue;
    CHECK(std::abs(band.c.value - 0.5575) < 5 * band.c.standard_error + 0.001);
    CHECK(std::abs(band.D.value - 0.08) < 5 * band.D.standard_error + 0.01);
  }
  CHECK(json[0].at("dispersion").size() == response.bands.size());
  const Figure relation = plot_dispersion({response}, run.path());
  check_at_widths_of_journals(run / "figures", relation.id);
  CHECK(relation.data.size() == 1);
  CHECK(contains(read_file(run.path() / relation.screen), "wave number k"));
  DeepResponse unknown = response;
  unknown.bands.clear();
  CHECK_THROWS_AS(plot_dispersion({unknown}, run.path()), InputError);
  for (OctaveOfDepth& octave : unknown.octaves) octave.exponent = {.reason = "no peaks"};
  CHECK_THROWS_AS(plot_deep_response({unknown}, run.path()), InputError);
}

TEST_CASE("The law of spreading is judged where it is farthest from diffusion, shallow and deep apart") {
  const auto at = [](double mu, double shallow, double deep) {
    DeepResponse one;
    one.spec.sampler.mu = mu;
    one.shallow = {55, 111, {shallow, 0.01, ""}};
    one.deep = {222, 887, {deep, 0.01, ""}};
    return one;
  };
  const ClaimSpec spec;
  const auto claims = judge_spreading({at(0.1, 1.02, 1.01), at(0.3, 1.04, 1.2)}, spec);
  REQUIRE(claims.size() == 2);
  CHECK(claims[0].verdict == reproduced);
  CHECK(claims[0].measured.value == 1.04);
  CHECK(claims[1].verdict == not_reproduced);
  CHECK(claims[1].measured.value == 1.2);
  CHECK(contains(claims[1].explanation, "z = 222 to 887 at μ = 0.3"));
  CHECK(contains(claims[1].statement, "from z = 222 to 887"));  // which depths are deep depends on the octaves
  CHECK(contains(claims[1].remarks, "1.010(10) at μ = 0.1"));
  // Most precise is not farthest: a rough exponent does not hide a clear one.
  DeepResponse rough = at(0.5, 1.3, 1.3);
  rough.deep.exponent.standard_error = 0.2;
  CHECK(judge_spreading({at(0.3, 1, 1.2), rough}, spec)[1].measured.value == 1.2);
  DeepResponse unknown = at(0.5, 1, 1);
  unknown.deep.exponent = {.reason = "no peaks"};
  CHECK(judge_spreading({unknown}, spec)[1].verdict == not_tested);
  // Nearer to the top than the paper looked, the claims have nothing to say.
  DeepResponse near = at(0.5, 1.9, 1.9);
  near.shallow.from = near.deep.from = 2;
  for (const Claim& claim : judge_spreading({near}, spec)) CHECK(claim.verdict == not_tested);
  CHECK(deep_response_study()->claims(spec).empty());
}

TEST_CASE("The deep response needs a ring of six widths, and for loads one on which its peaks are apart") {
  Asked narrow(31);
  CHECK(contains(narrow.study->find_problem(narrow.main)->message, "wider than a sixth of the ring"));
  CHECK(contains(narrow.study->find_problem(narrow.main)->message, "give 33 columns"));
  narrow.set("columns", std::int64_t{33});
  CHECK_FALSE(narrow.study->find_problem(narrow.main));

  const auto refused = [](std::int64_t columns, std::int64_t first_lag = 32) {
    Asked asked(columns);
    asked.set("first_lag", first_lag);
    asked.set("loaded_mu", std::vector<double>{0.3});
    return asked.study->find_problem(asked.main);
  };
  // At z = 222 each peak has gone 123 columns.
  const auto found = refused(250);
  REQUIRE(found);
  CHECK(contains(found->message, "meet on the ring"));
  CHECK(contains(found->message, "give 28"));
  CHECK_FALSE(refused(290));
  CHECK_FALSE(refused(180));
  CHECK(refused(50));  // less than twelve widths
  CHECK(refused(290, 40));

  // At mu = 0.2 alone 151 columns would do, which at 0.5 are too few: what is offered suits all of the table.
  Asked table(100);
  table.set("mu", std::vector<double>{0.2, 0.5, 0.8});
  table.set("loaded_mu", std::vector<double>{0.2, 0.5, 0.8});
  table.set("octaves", std::int64_t{5});
  CHECK(contains(table.study->find_problem(table.main)->message, "at mu = 0.2"));
  CHECK(contains(table.study->find_problem(table.main)->message, "give 636 columns"));
  table.set("columns", std::int64_t{636});
  CHECK_FALSE(table.study->find_problem(table.main));
  table.set("columns", std::int64_t{635});
  CHECK(table.study->find_problem(table.main));
}

TEST_CASE("The deep response takes reference and bases from its keys, loads none of them") {
  Asked asked(320);
  asked.set("loaded_mu", std::vector<double>{0.3});
  asked.set("reference_lag", std::int64_t{4});
  asked.set("first_base", std::int64_t{9});
  asked.set("base_step", std::int64_t{3});
  const std::vector<StudyEnsemble> ensembles = asked.study->ensembles(asked.main);
  CHECK(ensembles[0].spec.response.reference_lag == 4);
  CHECK(ensembles[0].spec.response.first_base == 9);
  CHECK(ensembles[0].spec.response.base_step == 3);
  CHECK_FALSE(find_problem(ensembles[1].spec));
}

TEST_CASE("Under the flat law W² grows much faster than z, beyond that of rows drawn one by one", "[long]") {
  const auto followed = [](Law law) {
    Asked asked(16);
    asked.set("mu", std::vector<double>{0.5});
    asked.set("first_lag", std::int64_t{1});
    asked.set("reference_lag", std::int64_t{2});
    asked.set("first_base", std::int64_t{1});
    asked.set("base_step", std::int64_t{1});
    asked.set("samples", std::int64_t{512});
    asked.main.sampling.law = law;
    if (law == Law::polytope) {
      asked.main.sampling.lambda = 0;
      asked.main.sampling.burn_in = 256;
      asked.main.sampling.thinning = 64;
    }
    REQUIRE_FALSE(asked.study->find_problem(asked.main));
    const EnsembleSpec spec = asked.study->ensembles(asked.main)[0].spec;
    return measure_spreading({spec, run_ensemble(spec, 2, nullptr)}, DeepMeasurement::fluctuations, 2);
  };
  const DeepResponse flat = followed(Law::polytope), rows = followed(Law::granusolve);
  const Estimate &of_flat = flat.lags[2].width_squared, &of_rows = rows.lags[2].width_squared;
  const Estimate& power = flat.octaves[1].exponent;  // from z = 1.7 to 3.5
  CAPTURE(of_flat.value, of_flat.standard_error, of_rows.value, of_rows.standard_error);
  CAPTURE(power.value, power.standard_error, rows.octaves[1].exponent.value);
  REQUIRE(power.known());
  REQUIRE(of_rows.known());
  // Piles of a chain are worth less than independent ones, of which nothing is said.
  CHECK(flat.effective_samples.value > 50);
  CHECK(flat.effective_samples.value < 512 + 4 * flat.effective_samples.standard_error);
  CHECK_FALSE(rows.effective_samples.known());
  CHECK(of_flat.value - 2 * of_rows.value > 4 * std::hypot(of_flat.standard_error, 2 * of_rows.standard_error));
  CHECK(power.value - 1 > 4 * power.standard_error);
  // Twice as deep its peaks are too wide for this ring, as those of rows are not.
  CHECK(contains(flat.octaves[2].exponent.reason, "wider than a sixth of the ring"));
  CHECK(rows.octaves[2].exponent.known());
}

namespace {

/// Lags at which the peaks of the linear model stand a third of its 240 columns apart, on whichever side: down to the
/// last one they would need 700.
const std::vector<int> third_of_ring{42, 84, 168, 336, 672};

double pull(const Estimate& estimate, double truth) { return (estimate.value - truth) / estimate.standard_error; }

/// W^2 as the fit has it, which takes a bead off.
double width_of_model(double z) { return test::LinearModel::D * z - 1.0 / 12; }

}  // namespace

TEST_CASE("Peaks that have gone around the ring are followed to where they are", "[unsanitized]") {
  constexpr double c = test::LinearModel::c, D = test::LinearModel::D;
  const MeasuredEnsemble ensemble = test::linear_ensemble({}, 3, 24, third_of_ring, 16, 4);
  const DeepResponse response = measure_spreading(ensemble, DeepMeasurement::fluctuations, 2);
  REQUIRE(response.octaves.size() == 4);
  for (const LagResponse& lag : response.lags) {
    CAPTURE(lag.z, lag.peak_position.value, lag.width_squared.value);
    CHECK(std::abs(pull(lag.peak_position, c * lag.z)) < 5);
    CHECK(std::abs(pull(lag.width_squared, width_of_model(lag.z))) < 5);
    CHECK(lag.peak_position.standard_error < 1);
  }
  for (const OctaveOfDepth& octave : response.octaves) {
    CAPTURE(octave.from, octave.exponent.value, octave.exponent.standard_error);
    CHECK(std::abs(pull(octave.c, c)) < 5);
    CHECK(std::abs(pull(octave.D, D)) < 5);
    CHECK(octave.c.standard_error < 0.01);
  }
  // At z = 213 peaks of W = 4 are 6 apart on the far side of the ring: their sum hardly tells x_p from W, but H tells
  // which of them comes from where.
  const MeasuredEnsemble meeting = test::linear_ensemble({}, 3, 24, {61, 123, 246}, 16, 4);
  const LagResponse met = measure_spreading(meeting, DeepMeasurement::fluctuations, 2).lags.back();
  CHECK(std::abs(pull(met.peak_position, c * met.z)) < 5);
  CHECK(std::abs(pull(met.width_squared, width_of_model(met.z))) < 5);
  CHECK(met.width_squared.standard_error < 2 * response.lags[3].width_squared.standard_error);
}

TEST_CASE("Exponents of octaves of depth have errors one can bet on, on a ring that peaks go around", "[long]") {
  constexpr int ensembles = 120;
  std::vector<double> inside(4), sum(4);
  for (int r = 0; r < ensembles; ++r) {
    const auto seed = 200 + static_cast<std::uint64_t>(r);
    const MeasuredEnsemble ensemble = test::linear_ensemble({}, seed, 24, third_of_ring, 32, 1);
    const DeepResponse response = measure_spreading(ensemble, DeepMeasurement::fluctuations, 2);
    for (std::size_t i = 0; i < 4; ++i) {
      const OctaveOfDepth& octave = response.octaves[i];
      const double truth = std::log2(width_of_model(octave.to) / width_of_model(octave.from));
      const double off = pull(octave.exponent, truth);
      inside[i] += std::abs(off) <= 1 ? 1.0 / ensembles : 0;
      sum[i] += off / ensembles;
    }
  }
  // 32 blocks: Student's t with 31 degrees of freedom. 800 exponents under other seeds had 68.1(1.6) %, and 94.0(0.8) %
  // within two errors, where t has 94.6.
  constexpr double share = 0.675;
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i, inside[i], sum[i]);
    CHECK(inside[i] == Approx(share).margin(0.128));  // three standard errors
    CHECK(std::abs(sum[i]) < 0.35);
  }
  const double of_all = std::accumulate(inside.begin(), inside.end(), 0.0) / 4;
  CAPTURE(of_all);
  CHECK(of_all == Approx(share).margin(0.064));
}

TEST_CASE("Exponents by loads have errors one can bet on", "[long]") {
  Asked asked(320);
  asked.set("loaded_mu", std::vector<double>{0.3});
  EnsembleSpec loads = asked.study->ensembles(asked.main).back().spec;
  loads.response.epsilon = 0.15;
  constexpr int ensembles = 120;
  std::vector<std::vector<Estimate>> found(3);
  for (int r = 0; r < ensembles; ++r) {
    loads.sampler.seed = 500 + static_cast<std::uint64_t>(r);
    const MeasuredEnsemble ensemble{loads, run_ensemble(loads, 0, nullptr)};
    const DeepResponse response = measure_spreading(ensemble, DeepMeasurement::loads, 2);
    for (std::size_t i = 0; i < 3; ++i) found[i].push_back(response.octaves[i].exponent);
  }
  double of_all = 0;
  for (const std::vector<Estimate>& octave : found) {
    double mean = 0, inside = 0;
    for (const Estimate& one : octave) mean += one.value / ensembles;
    for (const Estimate& one : octave) inside += std::abs(one.value - mean) <= one.standard_error ? 1.0 / ensembles : 0;
    CAPTURE(mean, inside);
    CHECK(inside == Approx(0.675).margin(0.128));  // three standard errors
    of_all += inside / 3;
  }
  CHECK(of_all == Approx(0.675).margin(0.075));
}

TEST_CASE("The deep response is checked in wide piles and by loads, at friction coefficients that it has",
          "[unsanitized]") {
  Asked asked(320);
  asked.set("wide_mu", std::vector<double>{0.3});
  asked.set("loaded_mu", std::vector<double>{0.3});
  asked.set("loaded_samples", std::int64_t{512});
  asked.main.response.epsilon = 0.15;
  CHECK_FALSE(asked.study->find_problem(asked.main));
  const std::vector<StudyEnsemble> ensembles = asked.study->ensembles(asked.main);
  REQUIRE(ensembles.size() == 3);
  CHECK(ensembles[1].spec.lattice.columns == 640);
  CHECK(ensembles[1].spec.lattice.layers == ensembles[0].spec.lattice.layers);
  EnsembleSpec loads = ensembles[2].spec;
  CHECK(name_of(loads.response.estimator) == "multiplexed");
  CHECK(loads.response.opposite);
  CHECK(loads.response.epsilon == 0.15);
  CHECK(ensembles[0].spec.response.samples == 256);
  CHECK(loads.response.samples == 512);
  CHECK(loads.response.sign_run == 1);
  asked.set("loaded_run", std::int64_t{8});
  CHECK_FALSE(asked.study->find_problem(asked.main));
  const std::vector<StudyEnsemble> runs = asked.study->ensembles(asked.main);
  CHECK(runs[2].spec.response.sign_run == 8);
  CHECK(configuration_text(runs[1].spec) == configuration_text(ensembles[1].spec));
  CHECK_FALSE(find_problem(runs[2].spec));
  asked.set("loaded_run", std::int64_t{41});
  const auto too_long = asked.study->find_problem(asked.main);
  REQUIRE(too_long);
  CHECK(too_long->key == "studies.deep_response.loaded_run");
  CHECK(contains(too_long->message, "at most 40"));
  asked.set("loaded_run", std::int64_t{1});
  // No reference and no bases: loads act at the top.
  loads.response.samples = 128;
  loads.response.blocks = 16;
  const MeasuredEnsemble few{loads, run_ensemble(loads, 0, nullptr)};
  const DeepResponse response = measure_spreading(few, DeepMeasurement::loads, 2);
  REQUIRE(response.lags.size() == 4);
  CHECK(nlohmann::ordered_json(response).at("by") == "loads");  // a name of its own beside the same mu
  CHECK(response.lags[0].lag == 32);
  CHECK(response.bands.empty());
  CHECK(std::abs(response.octaves[1].c.value - 0.5575) < 5 * response.octaves[1].c.standard_error + 0.001);
  CHECK(response.c_thrust.value == Approx(0.5557).margin(0.001));
  // H tells the same peaks twice: without it errors are larger.
  MeasuredEnsemble of_weights = few;
  REQUIRE(of_weights.record.sums.quantities.erase("correlation_H") == 1);
  const DeepResponse by_weights = measure_spreading(of_weights, DeepMeasurement::loads, 2);
  double variance = 0, variance_by_weights = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Estimate &one = response.octaves[i].exponent, &other = by_weights.octaves[i].exponent;
    CHECK(std::abs(one.value - other.value) < 4 * other.standard_error);
    variance += std::pow(one.standard_error, 2);
    variance_by_weights += std::pow(other.standard_error, 2);
  }
  CAPTURE(variance, variance_by_weights);
  CHECK(variance < 0.75 * variance_by_weights);
  // A check alone decides nothing.
  CHECK(judge_spreading({response}, {})[0].verdict == not_tested);

  asked.set("wide_mu", std::vector<double>{0.2});
  const auto found = asked.study->find_problem(asked.main);
  REQUIRE(found);
  CHECK(contains(found->message, "0.2 is not in studies.deep_response.mu"));
  Asked few_loads(320);
  few_loads.set("loaded_samples", std::int64_t{10});
  const auto too_few = few_loads.study->find_problem(few_loads.main);
  REQUIRE(too_few);
  CHECK(too_few->key == "studies.deep_response.loaded_samples");
}

TEST_CASE("Page 1 tells spreading from diffusion as its claim does, and checks from measurements") {
  const auto one = [](double mu, const Estimate& power) {
    DeepResponse response;
    response.spec.sampler.mu = mu;
    response.octaves.resize(2);
    response.deep = {222, 887, power};
    return response;
  };
  const auto told = [](const std::vector<DeepResponse>& list) { return spreading_page_1(list, {}, "/list"); };
  const DeepResponse slow = one(0.1, {1.02, 0.01, {}}), fast = one(0.3, {1.2, 0.03, {}}),
                     check = one(0.3, {1.3, 0.04, {}}), open = one(0.5, {});
  const auto both = told({slow, fast, check, open});
  CHECK(both.at("some_fast") == true);
  CHECK(both.at("fast") == "μ = 0.3");
  CHECK(both.at("slow") == "μ = 0.1");
  CHECK(both.at("deep").size() == 2);
  CHECK(both.at("deep")[0].at("joint") == " and ");
  CHECK(both.at("largest").at("key") == "/list/1");
  CHECK(both.at("last_octave").at("key") == "/list/1/octaves/1");
  CHECK(both.at("apart") == "2.0");  // 0.1 over 0.05
  CHECK(told({fast}).at("all_fast") == true);
  CHECK(told({slow}).at("none_fast") == true);
  // Each word as the claim decides: four errors off and within its tolerance, too rough, and nearer than it looks.
  DeepResponse near = fast;
  near.deep.from = 20;
  for (const DeepResponse& each : {slow, fast, one(0.3, {1.059, 0.014, {}}), one(0.3, {1.07, 0.1, {}}), near}) {
    const std::string verdict = judge_spreading({each}, {})[1].verdict;
    CAPTURE(each.deep.exponent.value, verdict);
    CHECK(told({each}).at("all_fast") == (verdict == not_reproduced));
    CHECK(told({each}).at("none_fast") == (verdict == reproduced));
    CHECK(told({each}).at("open") == (verdict == not_decided || verdict == not_tested));
  }
  CHECK(told({slow}).at("checked") == false);
  CHECK(told({open}).is_null());
}

TEST_CASE("Peaks whose halves run at two speeds are seen to spread as z, their W² as its square", "[long]") {
  // Where layers are solved from bead 0 rightwards, left and right peaks move at two speeds, and the mean of a pile and
  // its mirror image has both: what it adds to the W² of random order is (Δc z/2)². At mu = 1.2 that shows from z =
  // 400.
  const auto followed = [](LayerOrder order) {
    Asked asked(1600);
    asked.set("mu", std::vector<double>{1.2});
    asked.set("octaves", std::int64_t{5});
    EnsembleSpec spec = asked.study->ensembles(asked.main)[0].spec;
    spec.sampler.order = order;
    return measure_spreading({spec, run_ensemble(spec, 2, nullptr)}, DeepMeasurement::fluctuations, 2);
  };
  const DeepResponse of_fixed = followed(LayerOrder::fixed), of_random = followed(LayerOrder::random);
  const auto added = [&](std::size_t lag) {
    const Estimate &a = of_fixed.lags[lag].width_squared, &b = of_random.lags[lag].width_squared;
    return Estimate{a.value - b.value, std::hypot(a.standard_error, b.standard_error), {}};
  };
  const std::size_t last = of_fixed.lags.size() - 1;
  const Estimate above = added(last - 1), below = added(last);
  // The two lags count as independent, which makes the error larger than it is.
  const Estimate power{
      std::log2(below.value / above.value),
      std::hypot(below.standard_error / below.value, above.standard_error / above.value) / std::numbers::ln2,
      {}};
  const Estimate fixed = of_fixed.octaves.back().exponent, random = of_random.octaves.back().exponent;
  CAPTURE(above.value, below.value, power.value, power.standard_error);
  CAPTURE(fixed.value, fixed.standard_error, random.value, random.standard_error);
  REQUIRE(power.standard_error < 0.15);
  CHECK(std::abs(pull(power, 2)) < 3);
  CHECK(fixed.value - random.value > 5 * std::hypot(fixed.standard_error, random.standard_error));
  CHECK(pull(random, 2) < -5);
}
