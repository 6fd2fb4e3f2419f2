#include <sys/wait.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/in_process.h"
#include "kit/temporary_folder.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

int status_of(const std::string& command) {
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): nothing else runs
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

CommandResult exported(const std::filesystem::path& source, const std::filesystem::path& file,
                       std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"export", source.string(), "--out", file.string()});
  return granuscope_command(std::move(more));
}

void store_pile(const std::filesystem::path& file, const std::string& columns, const std::string& mu) {
  REQUIRE(granuscope_command(
              {"sample", "--mu", mu, "--columns", columns, "--layers", "5", "--load", "point", "--out", file.string()})
              .code == 0);
}

/// A finished ensemble of few piles. Without friction the response stands on two lines of beads.
std::string ensemble_in(const test::TemporaryFolder& folder, const std::string& estimator = "point",
                        const std::string& mu = "0", const std::string& layers = "64") {
  std::ofstream(folder / "e.toml") << "[lattice]\ncolumns = 64\nlayers = " << layers << "\n[friction]\nmu = [" << mu
                                   << "]\n[response]\nestimator = \"" << estimator
                                   << "\"\nsamples = 64\n[fit]\nfirst_layer = 24\nlast_layer = 42\n";
  const std::string out = (folder / estimator).string();
  REQUIRE(granuscope_command({"run", (folder / "e.toml").string(), "--out", out, "--only", "sample"}).code == 0);
  return out + "/ensembles/mu-" + mu + ".h5";
}

/// Array number `which` of a file of VTK, all of 8 bytes an item, by decoding each letter of its base64.
std::vector<double> array_of(const std::string& file, std::size_t which) {
  std::size_t at = 0;
  const std::string before = "format=\"binary\">\n";
  for (std::size_t k = 0; k <= which; ++k) at = file.find(before, at) + before.size();
  const std::string text = file.substr(at, file.find('\n', at) - at);
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int known = 0;
  for (const char one : text) {
    if (one == '=') break;
    REQUIRE(letters.find(one) != std::string::npos);
    bits = bits << 6 | static_cast<std::uint32_t>(letters.find(one));
    known += 6;
    if (known < 8) continue;
    known -= 8;
    bytes += static_cast<char>(bits >> known & 0xFF);
  }
  std::uint64_t size = 0;
  REQUIRE(bytes.size() > sizeof size);
  std::memcpy(&size, bytes.data(), sizeof size);
  REQUIRE(bytes.size() == sizeof size + size);
  std::vector<double> numbers(size / sizeof(double));
  std::memcpy(numbers.data(), bytes.data() + sizeof size, size);
  return numbers;
}

struct CsvRow {
  double x, z, P, error;
};

std::vector<CsvRow> rows_of(const std::filesystem::path& csv) {
  std::vector<CsvRow> rows;
  std::ifstream in(csv);
  for (std::string line; std::getline(in, line);) {
    if (line[0] == '#' || line[0] == 'x') continue;
    CsvRow row{};
    REQUIRE(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &row.x, &row.z, &row.P, &row.error) == 4);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

TEST_CASE("Every format of a pile says what the pile file says, to the programs that read it") {
  const std::string python = "/usr/bin/python3";
  if (status_of(python + " -c 'import numpy, h5py' 2>/dev/null") != 0) {
    WARN("no " << python << " with h5py here: nothing was tested");
    return;
  }
  // The smallest ring has each bead twice below another one; an odd ring; sliding contacts; none that slides.
  for (const auto& [columns, mu] : {std::pair{"4", "0.1"}, {"7", "0.6"}, {"12", "0"}}) {
    INFO(columns << " columns, mu " << mu);
    const test::TemporaryFolder folder;
    const auto pile = folder / "pile.h5";
    store_pile(pile, columns, mu);
    for (const char* name : {"pile.vtu", "pile.graphml", "pile.csv", "pile.local"}) {
      const CommandResult result = exported(pile, folder / name);
      INFO(result.err);
      CHECK(result.code == 0);
    }
    CHECK(exported(pile, folder / "beads.csv", {"--part", "beads"}).code == 0);
    CHECK(exported(pile, folder / "beads.dump", {"--part", "beads"}).code == 0);
    CHECK(exported(pile, folder / "walls.local", {"--part", "walls"}).code == 0);
    CHECK(exported(pile, folder / "pile.txt", {"--format", "pegs"}).code == 0);
    CHECK(exported(pile, folder / "beads.txt", {"--format", "pegs", "--part", "beads"}).code == 0);
    const std::string at = folder.path().string();
    const int status = status_of(python + " '" GRANUSCOPE_SOURCE_DIR "/tests/cli/read_exports.py' '" + pile.string() +
                                 "' '" + at + "' >'" + at + "/readers' 2>&1");
    const std::string readers = read_file(folder / "readers");
    INFO(readers);
    CHECK(status == 0);
    if (status != 0) continue;
    for (const char* reader : {"networkx", "meshio"}) {
      if (readers.find(reader) == std::string::npos) WARN("without python3-" << reader << " its format is not read");
    }
  }
}

TEST_CASE("An export gives the same bytes again, and takes the place of nothing that it did not write") {
  const test::TemporaryFolder folder;
  const auto pile = folder / "pile.h5";
  store_pile(pile, "8", "0.3");
  const std::string before = read_file(pile);
  for (const char* name : {"a.vtu", "a.graphml", "a.csv", "a.local"}) {
    INFO(name);
    REQUIRE(exported(pile, folder / name).code == 0);
    const std::string first = read_file(folder / name);
    REQUIRE(exported(pile, folder / name, {"--force"}).code == 0);
    CHECK((read_file(folder / name) == first));
    std::ofstream(folder / name) << "mine";
    const CommandResult refused = exported(pile, folder / name);
    CHECK(refused.code == 2);
    CHECK(read_file(folder / name) == "mine");
  }
  const CommandResult itself = exported(pile, pile, {"--format", "csv", "--force"});
  CHECK(itself.code == 2);
  CHECK((read_file(pile) == before));
}

TEST_CASE("export refuses what cannot be, says what can, and leaves no file") {
  const test::TemporaryFolder folder;
  const auto pile = folder / "pile.h5";
  store_pile(pile, "8", "0.3");
  const std::string ensemble = ensemble_in(folder);
  std::ofstream(folder / "text.h5") << "no pile";
  struct Refused {
    std::string source, file;
    std::vector<std::string> more;
    std::string said;
  };
  const std::vector<Refused> cases{
      {pile.string(), "a.xyz", {}, "let it end with .vtu, .local, .dump, .pegs, .graphml, .csv, .vti"},
      {pile.string(), "a.csv", {"--format", "vtu"}, "let both say the same"},
      {pile.string(), "a.vti", {}, "a pile, which can be exported as"},
      {pile.string(), "a.csv", {"--format", "ovito"}, "ovito"},
      {pile.string(), "a.vtu", {"--part", "beads"}, "leave out --part"},
      {pile.string(), "a.csv", {"--part", "floors"}, "known are contacts, beads and walls"},
      {pile.string(), "a.csv", {"--part", "walls"}, "has contacts with the floor among the others; leave out --part"},
      {ensemble, "a.vtu", {}, "an ensemble, which can be exported as"},
      {ensemble, "a.csv", {"--part", "beads"}, "leave out --part"},
      {(folder / "text.h5").string(), "a.csv", {}, "text.h5"},
      {(folder / "none.h5").string(), "a.csv", {}, "none.h5"},
  };
  for (const Refused& one : cases) {
    const CommandResult result = exported(one.source, folder / one.file, one.more);
    INFO(one.file << ": " << result.err);
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains(one.said));
    CHECK_FALSE(std::filesystem::exists(folder / one.file));
  }
  const CommandResult nowhere = exported(pile, folder / "none/a.csv");
  INFO(nowhere.err);
  CHECK(nowhere.code != 0);
}

TEST_CASE("The mean response of an ensemble is a field whose layers add up to the overload") {
  const std::string estimator = GENERATE("point", "multiplexed");
  INFO(estimator);
  const test::TemporaryFolder folder;
  const std::string ensemble = ensemble_in(folder, estimator);
  REQUIRE(exported(ensemble, folder / "P.csv").code == 0);
  REQUIRE(exported(ensemble, folder / "P.vti").code == 0);
  const std::vector<CsvRow> rows = rows_of(folder / "P.csv");
  REQUIRE(rows.size() % 64 == 0);
  const std::string vti = read_file(folder / "P.vti");
  const std::vector<double> image = array_of(vti, 0), errors = array_of(vti, 1);
  const std::size_t width = 2 * 64, height = image.size() / width;
  REQUIRE(errors.size() == image.size());
  const double lowest = rows.back().z, spacing = std::atof(vti.c_str() + vti.find("Spacing=\"0.5 ") + 13);
  CHECK_THAT(vti, Contains("Origin=\"-32 "));
  for (std::size_t first = 0; first < rows.size(); first += 64) {
    double sum = 0;
    for (std::size_t k = first; k < first + 64; ++k) {
      const CsvRow& row = rows[k];
      INFO(row.x << ' ' << row.z);
      // Without friction half of the overload goes down each line of contacts, at 30 degrees; the first centre is at
      // 0.5.
      const double ray = (row.z - 0.5) / std::sqrt(3.0);
      const int rays = (std::abs(row.x - ray) < 0.01 ? 1 : 0) + (std::abs(row.x + ray) < 0.01 ? 1 : 0);
      CHECK(row.P == Approx(0.5 * rays).margin(1e-9));
      sum += row.P;
      // Both halves of the bead's cell, looked up by their middles as a program does that reads the image.
      const auto image_row = static_cast<std::size_t>(std::lround((lowest - row.z) / spacing));
      REQUIRE(image_row < height);
      CHECK((lowest - row.z) / spacing == Approx(static_cast<double>(image_row)).margin(1e-6));
      for (const double middle : {row.x - 0.25, row.x + 0.25}) {
        const auto half = static_cast<std::size_t>(std::lround(std::floor(2 * (middle + 32) + width))) % width;
        CHECK(image[image_row * width + half] == row.P);
        CHECK(errors[image_row * width + half] == row.error);
      }
    }
    CHECK(sum == Approx(1).margin(1e-6));
  }
}

TEST_CASE("Where fluctuations tell the response it is a field, too, and where nothing fluctuates that is said") {
  const test::TemporaryFolder folder;
  REQUIRE(exported(ensemble_in(folder, "fluctuation", "0.3", "160"), folder / "P.csv").code == 0);
  std::map<double, std::array<double, 2>> shares;  // of the layer, and of its part around the two peaks
  for (const CsvRow& row : rows_of(folder / "P.csv")) {
    shares[row.z][0] += row.P;
    if (std::abs(std::abs(row.x) - 0.57 * row.z) < 3) shares[row.z][1] += row.P;  // c at this friction coefficient
  }
  REQUIRE(shares.size() > 4);
  for (const auto& [z, share] : shares) {
    INFO(z);
    CHECK(share[0] == Approx(1));
    CHECK(share[1] > 0.7);  // of six beads on either side 0.98 with noise of some 0.1; of none but noise 0.2
  }
  const CommandResult still = exported(ensemble_in(folder, "fluctuation", "0", "160"), folder / "none.csv");
  CHECK(still.code == 2);
  CHECK_THAT(still.err, Contains("nothing fluctuates in its piles"));
  CHECK_FALSE(std::filesystem::exists(folder / "none.csv"));
}

TEST_CASE("What export writes, contacts reads again: the same forces, in balance") {
  const test::TemporaryFolder folder;
  const auto pile = folder / "pile.h5";
  store_pile(pile, "9", "0.4");
  for (const auto& [name, format, part] : {std::tuple{"a.csv", "csv", "contacts"},
                                           {"beads.csv", "csv", "beads"},
                                           {"a.vtu", "vtu", ""},
                                           {"a.local", "dump-local", "contacts"},
                                           {"beads.dump", "dump-local", "beads"},
                                           {"walls.local", "dump-local", "walls"},
                                           {"a.txt", "pegs", "contacts"},
                                           {"beads.txt", "pegs", "beads"}}) {
    std::vector<std::string> more{"--format", format};
    if (*part != '\0') more.insert(more.end(), {"--part", part});
    const CommandResult written = exported(pile, folder / name, more);
    REQUIRE(written.code == 0);
    CHECK(exported(pile, folder / name, more).code == 0);  // what this program wrote it may replace
    // What a format cannot say is told with its count.
    const std::string file = name;
    const bool floor = written.err.find("push on the floor, which is no bead: 18 of 90 contacts") != std::string::npos;
    CHECK(floor == (file == "a.local"));
    const bool seam = written.err.find("4 contacts join beads at either end") != std::string::npos &&
                      written.err.find("--period-x 9\n") != std::string::npos;
    CHECK(seam == (file == "a.txt"));
  }
  const auto numbers = [&](const std::string& contacts, std::vector<std::string> more) {
    more.insert(more.begin(), {"contacts", (folder / contacts).string(), "--json", "--mu", "0.4"});
    const CommandResult result = granuscope_command(std::move(more));
    INFO(result.err);
    REQUIRE(result.code == 0);
    return nlohmann::json::parse(result.out);
  };
  const auto beads = [&](const char* name) { return (folder / name).string(); };
  const nlohmann::json table = numbers("a.csv", {"--particles", beads("beads.csv")});
  const nlohmann::json pegs = numbers("a.txt", {"--particles", beads("beads.txt"), "--period-x", "9"});
  CHECK(table["contacts"] == 2 * 9 * 5);
  CHECK(table["cone_violations"] == 0);
  CHECK(table["torque_max"].get<double>() < 1e-12);
  CHECK(table["balance_median"].get<double>() < 1e-12);
  for (const char* name : {"N_mean", "N2", "N3", "N_max", "T_over_N", "sliding", "coordination"}) {
    INFO(name);
    CHECK(table[name].get<double>() == Approx(pegs[name].get<double>()).epsilon(1e-12));
  }
  CHECK(numbers("a.local", {"--particles", beads("beads.dump")})["contacts"] == 2 * 9 * 4);
  const nlohmann::json dump = numbers(
      "a.local", {"--particles", beads("beads.dump"), "--walls", beads("walls.local"), "-o", beads("dump.svg")});

  // All that a vtu file says of itself; the picture is that of the table, too.
  const nlohmann::json vtu = numbers("a.vtu", {"-o", beads("vtu.svg")});
  for (const auto& [name, value] : table.items()) {
    INFO(name);
    if (!value.is_number()) continue;
    for (const auto& other : {vtu, dump}) {
      CHECK(other[name].get<double>() == Approx(value.get<double>()).epsilon(1e-12).margin(1e-13));
    }
  }
  (void)numbers("a.csv", {"--particles", beads("beads.csv"), "-o", beads("csv.svg")});
  const auto drawn = [&](const char* name) {
    const std::string svg = read_file(folder / name);
    return svg.substr(svg.find("<path"));
  };
  CHECK((drawn("vtu.svg") == drawn("csv.svg")));
  CHECK((drawn("dump.svg") == drawn("csv.svg")));
}

TEST_CASE("contacts reads what VTK writes in each of its encodings") {
  const std::string python = "/usr/bin/python3";
  if (status_of(python + " -c 'import vtkmodules' 2>/dev/null") != 0) {
    WARN("no python3-vtk9 here: nothing was tested");
    return;
  }
  const test::TemporaryFolder folder;
  store_pile(folder / "pile.h5", "9", "0.4");
  REQUIRE(exported(folder / "pile.h5", folder / "pile.vtu").code == 0);
  const std::string at = folder.path().string();
  const auto numbers = [&](const std::string& file) {
    const CommandResult result = granuscope_command({"contacts", at + "/" + file, "--json", "--mu", "0.4"});
    INFO(file << result.err);
    CHECK(result.code == 0);
    return nlohmann::json::parse(result.out.empty() ? "{}" : result.out);
  };
  REQUIRE(status_of(python + " '" GRANUSCOPE_SOURCE_DIR "/tests/cli/write_vtk.py' '" + at + "/pile.vtu' '" + at +
                    "' >'" + at + "/written'") == 0);
  const nlohmann::json expected = numbers("pile.vtu");
  std::ifstream written(folder / "written");
  std::size_t files = 0;
  for (std::string name; std::getline(written, name); ++files) {
    const nlohmann::json found = numbers(name);
    REQUIRE(found.size() == expected.size());
    const bool rounded = name.find("legacy-False") == 0;  // plain text of VTK's legacy files has some six digits
    for (const auto& [key, value] : expected.items()) {
      INFO(name << ' ' << key);
      if (!value.is_number()) continue;
      CHECK(found[key].get<double>() ==
            Approx(value.get<double>()).epsilon(rounded ? 1e-4 : 1e-12).margin(rounded ? 1e-8 : 1e-12));
    }
    // Half of any of them is told to be cut, whatever is missing.
    const std::string whole = read_file(folder / name);
    write_file(folder / "cut.vtk", whole.substr(0, whole.size() / 2));
    const CommandResult cut = granuscope_command({"contacts", at + "/cut.vtk"});
    INFO(name << ": " << cut.err);
    CHECK(cut.code == 2);
  }
  CHECK(files == 40);
}

TEST_CASE("A histogram of friction names what forces are counted in, with the friction coefficient and without") {
  const test::TemporaryFolder folder;
  const std::string contacts = (folder / "c.csv").string(), histogram = (folder / "h.csv").string();
  std::ofstream(contacts) << "x1,y1,x2,y2,normal,shear\n0,0,1,0,1,0.125\n1,0,2,0,1,0.125\n";
  const auto rows = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"contacts", contacts,   "--columns",   "N=normal, T=shear",
                                      "--of",     "friction", "--histogram", histogram};
    words.insert(words.end(), more.begin(), more.end());
    const CommandResult result = granuscope_command(words);
    INFO(result.err);
    CHECK(result.code == 0);
    return read_file(histogram);
  };
  // |T|/N = 0.125 lies in the third bin of 0.05, |T|/(μN) = 0.625 with μ = 0.2 in the thirteenth.
  CHECK_THAT(rows({}), Contains("\n#N,N,1/(N),1/(N)\n") && Contains("\n0.1,0.15000000000000002,20,"));
  CHECK_THAT(rows({"--mu", "0.2"}),
             Contains("\n#mu N,mu N,1/(mu N),1/(mu N)\n") && Contains("\n0.6000000000000001,0.6500000000000001,20,"));
}
