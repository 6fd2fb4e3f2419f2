#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "kit/temporary_folder.h"
#include "packing/number_table.h"
#include "packing/packing_file.h"
#include "packing/packing_scene.h"
#include "packing/packing_statistics.h"
#include "render/sample_grid.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

Packing packing_of(const test::TemporaryFolder& folder, const std::string& contacts, const std::string& particles = "",
                   PackingFiles files = {}, std::optional<double> step = std::nullopt) {
  write_file(folder / "contacts", contacts);
  files.contacts = folder / "contacts";
  if (!particles.empty()) {
    write_file(folder / "particles", particles);
    files.particles = folder / "particles";
  }
  return PackingSource(files).read(step);
}

std::map<std::string, double> numbers_of(const Packing& packing, double mu = std::nan("")) {
  std::map<std::string, double> numbers;
  for (const PackingNumber& one : packing_numbers(packing, mu)) numbers[one.name] = one.value;
  return numbers;
}

/// Three discs of radius 1/2 in a row, pressed together by 2 from either side, the right contact with friction 0.5.
const std::string row_of_three =
    "# made by hand\n"
    "x1,y1,x2,y2,id1,id2,fx,fy\n"
    "#m,m,m,m,-,-,N,N\n"
    "0,0,1,0,1,2,2,0\n"
    "1,0,2,0,2,3,2,0.5\n";
const std::string three_discs = "id x y radius\n1 0 0 0.5\n2 1 0 0.5\n3 2 0 0.5\n4 9 9 0.5\n";

}  // namespace

TEST_CASE("Tables as spreadsheets of all languages write them give the same numbers") {
  const test::TemporaryFolder folder;
  const std::string bom = "\xef\xbb\xbf";
  for (const std::string& contacts :
       {bom + "id1;id2;N;T\r\n1;2;1,25;-0,5\r\n2;3;2;0\r\n", std::string("id1;id2;N;T\n1;2;1.25;-0.5\n2;3;2;0\n"),
        std::string("id1,id2,N,T\n1,2,1.25,-0.5\n2,3,2,0\n"),
        std::string("id1\tid2\tN\tT\n1\t2\t1.25\t-0.5\n2\t3\t2\t0\n")}) {
    CAPTURE(contacts);
    const Packing packing =
        packing_of(folder, contacts, bom + "id;x;y;radius\r\n1;0;0;0,5\r\n2;1;0;0,5\r\n3;2;0;0,5\r\n");
    REQUIRE(packing.contacts.size() == 2);
    CHECK(packing.contacts[0].N == 1.25);
    CHECK(packing.contacts[0].T == -0.5);
    CHECK(packing.contacts[1].N == 2);
    CHECK(numbers_of(packing)["mean_diameter"] == 1);
  }
  PackingFiles named;
  named.columns = {"id1", "id2", "N"};
  CHECK(packing_of(folder, "1;2;0,75\n", three_discs, named).contacts[0].N == 0.75);
}

TEST_CASE("Forces as vectors become normal and tangential parts, and the numbers are those of a small packing") {
  const test::TemporaryFolder folder;
  const Packing packing = packing_of(folder, row_of_three, three_discs);
  REQUIRE(packing.contacts.size() == 2);
  CHECK(packing.contacts[0].N == 2);
  CHECK(packing.contacts[0].T == 0);
  CHECK(packing.contacts[1].N == 2);
  CHECK(packing.contacts[1].T == 0.5);  // to the left of +x is +y
  std::map<std::string, double> numbers = numbers_of(packing, 0.25);
  CHECK(numbers["particles"] == 4);
  CHECK(numbers["contacts"] == 2);
  CHECK(numbers["rattlers"] == 3);      // both ends, and the disc that nothing touches
  CHECK(numbers["coordination"] == 2);  // of the one in the middle; ends on rattlers are not its
  CHECK(numbers["mean_diameter"] == 1);
  CHECK(numbers["N_mean"] == 2);
  CHECK(numbers["N2"] == Approx(1));
  CHECK(numbers["T_over_N"] == Approx(0.125));
  CHECK(numbers["T_over_N_max"] == Approx(0.25));
  CHECK(numbers["sliding"] == Approx(0.5));
  CHECK(numbers["cone_violations"] == 0);
  CHECK(numbers_of(packing, 0.2)["cone_violations"] == 1);
  CHECK(numbers_of(packing, 0.2)["sliding"] == 0.5);
  CHECK(std::isnan(numbers_of(packing)["sliding"]));
  std::map<std::string, double> normal_only =
      numbers_of(packing_of(folder, "id1 id2 N\n1 2 2\n2 3 2\n", three_discs), 0.2);
  for (const char* name : {"T_over_N", "T_over_N_max", "sliding", "cone_violations", "torque_max"}) {
    CHECK(std::isnan(normal_only[name]));
  }
  CHECK(numbers["fabric_anisotropy"] == Approx(1));  // all branches along x
  CHECK(numbers["fabric_angle"] == Approx(0).margin(1e-12));
  // The disc in the middle is pushed by 2 from the left, and by -2 and -0.5 from the right.
  CHECK(numbers["balance_max"] == Approx(0.5 / std::hypot(2, 0.5)));
  CHECK(numbers["torque_max"] == Approx(0.5 / std::hypot(2, 0.5)));
}

TEST_CASE("Every way of writing the same contacts is read as the same packing") {
  const test::TemporaryFolder folder;
  const Packing expected = packing_of(folder, row_of_three, three_discs);
  const std::string dump =
      "ITEM: TIMESTEP\n10\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS ff ff pp\n0 1\n0 1\n0 1\n"
      "ITEM: ENTRIES x1 y1 z1 x2 y2 z2 id1 id2 periodic fx fy fz\n5 0 0 6 0 0 1 2 0 7 0 0\n"
      "ITEM: TIMESTEP\n20\nITEM: NUMBER OF ENTRIES\n2\nITEM: BOX BOUNDS ff ff pp\n0 1\n0 1\n0 1\n"
      "ITEM: ENTRIES x1 y1 z1 x2 y2 z2 id1 id2 periodic fx fy fz\n"
      "0 0 0 1 0 0 1 2 0 -2 0 0\n1 0 0 2 0 0 2 3 0 -2 -0.5 0\n";  // forces on the first particle
  const std::vector<std::pair<std::string, std::string>> files{
      {dump, three_discs},
      {"id1\tid2\tN\tT\r\n1\t2\t2\t0\r\n2\t3\t2\t0.5\r\n", three_discs},
      {"\xef\xbb\xbfID1; ID2; \"Fn [N]\"; Ft (N)\n1; 2; 2.0; +0\n\n2; 3; 2e0; 5e-1\n", three_discs},
      {"1,1,2,0,2\n1,2,1,0,2\n1,2,3,0.5,2\n1,3,2,0.5,2\n",
       "1,1,0,0,0.5,0\n1,2,1,0,0.5,0\n1,3,2,0,0.5,0\n1,4,9,9,0.5,0\n"},
      {"upper,lower,x_upper,z_upper,branch_x,branch_z,N,T\n1,2,0,0,1,0,2,0\n2,3,1,0,1,0,2,0.5\n", three_discs},
      {"id1,id2,N,T\n\"1\",\"2\",\"2\",\"0\"\n2,3,2,0.5\n3,2,2.00001,0.5\n", three_discs},  // rounded on either side
      {"id1,id2,N,T # by hand\n1,2,2,0 # first\n2,3,2,0.5\n", three_discs},
      {"id1\tid2\tN\tT\t# by hand\n1\t2\t2\t0\t# first\n2\t3\t2\t0.5\n", three_discs},
      {"frame,id1,id2,N,T\n3,1,2,9,9\n7,1,2,2,0\n7,2,3,2,0.5\n", three_discs},
  };
  for (const auto& [contacts, particles] : files) {
    INFO(contacts);
    const Packing packing = packing_of(folder, contacts, particles);
    REQUIRE(packing.contacts.size() == 2);
    for (const std::size_t k : {0, 1}) {
      CHECK(packing.contacts[k].N == expected.contacts[k].N);
      CHECK(packing.contacts[k].T == expected.contacts[k].T);
      CHECK(packing.contacts[k].branch_x == 1);
      CHECK(packing.particles[packing.contacts[k].first].id == static_cast<int>(k) + 1);
    }
  }
  CHECK(packing_of(folder, dump, "", {}, 10).contacts[0].N == 7);
  PackingFiles named;
  named.columns = {"id1", "id2", "ignored", "N"};
  CHECK(packing_of(folder, "1 2 5 2\n2 3 5 2\n", three_discs, named).contacts[1].N == 2);
}

TEST_CASE("Of a contact that both its particles tell, each by itself, the mean counts and the difference is told") {
  const test::TemporaryFolder folder;
  // As PeGS measures disks one by one; T may have either sign seen from the other side.
  const Packing packing = packing_of(folder, "id1 id2 N T\n1 2 2 0.3\n2 1 3 -0.1\n2 3 2 0.5\n", three_discs);
  REQUIRE(packing.contacts.size() == 2);
  CHECK(packing.twins == 1);
  CHECK(packing.contacts[0].N == 2.5);
  CHECK(packing.contacts[0].T == Approx(0.2));
  CHECK_THAT(packing.told.back(),
             Contains("1 contact is told again from the other side") && Contains("differ by 41 %"));
}

TEST_CASE("Contacts with walls are drawn where the file says where they touch, whichever program wrote it") {
  const test::TemporaryFolder folder;
  const std::string pairs = "id1 id2 N T\n1 2 2 0\n2 3 2 0.5\n";
  // The disc 2 stands on a floor, which holds it by 0.5 upwards and drags it by 0.1 to the right. As LIGGGHTS and
  // LAMMPS list it, the latter with all discs, and in one table with the other contacts.
  PackingFiles liggghts, lammps, none;
  liggghts.wall_columns = {"contact_x", "contact_y", "contact_z", "x1", "y1", "z1",
                           "mesh",      "triangle",  "id1",       "fx", "fy", "fz"};
  lammps.wall_columns = {"id1=id", "fx=f_w[2]", "fy=f_w[3]", "contact_x=f_w[5]", "contact_y=f_w[6]"};
  const std::string head = "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ENTRIES\n";
  for (const auto& [files, walls] : std::vector<std::pair<PackingFiles, std::string>>{
           {liggghts,
            head + "1\nITEM: ENTRIES c_w[1] c_w[2] c_w[3] c_w[4] c_w[5] c_w[6] c_w[7] c_w[8] c_w[9] c_w[10] c_w[11] "
                   "c_w[12]\n1 -0.5 0 1 0 0 0 17 2 0.1 0.5 0\n"},
           {lammps,
            head +
                "3\nITEM: ATOMS id f_w[1] f_w[2] f_w[3] f_w[5] f_w[6]\n1 0 0 0 0 0\n2 1 0.1 0.5 1 -0.5\n3 0 0 0 0 0\n"},
           {none, "id1,id2,contact_x,contact_y,N,T\n2,-1,1,-0.5,0.5,0.1\n"}}) {
    INFO(walls);
    PackingFiles both = files;
    write_file(folder / "walls", walls);
    both.walls = folder / "walls";
    const Packing packing = packing_of(folder, pairs, three_discs, both);
    REQUIRE(packing.contacts.size() == 3);
    const PackingContact& wall = packing.contacts[2];
    CHECK(wall.second == PackingContact::wall);
    CHECK(packing.particles[wall.first].id == 2);
    CHECK(wall.placed);
    CHECK(wall.branch_x == 0);
    CHECK(wall.branch_y == -1);
    CHECK(wall.N == 0.5);
    CHECK(std::abs(wall.T) == 0.1);
    SceneSpec spec;
    spec.coordinates = Coordinates::packing;
    const Scene scene = build_packing_scene(packing, 0, spec);
    CHECK(scene.counts.drawn == 3);
    std::size_t upright = 0;
    scene.elements({-9, 9, -9, 9}, [&](const Element& one) { upright += one.z0 != one.z1 && one.z1 == 0.5 ? 1 : 0; });
    CHECK(upright == 1);  // from the centre to the floor
  }
  // Without a place it counts, and no more.
  const Packing apart = packing_of(folder, pairs + "2 -1 0.5 0.1\n", three_discs);
  CHECK(numbers_of(apart)["wall_contacts"] == 1);
  CHECK_FALSE(apart.contacts[2].placed);
  // A step may have none; another step than that of the contacts is no answer.
  PackingFiles steps = liggghts;
  steps.walls = folder / "walls";
  write_file(folder / "walls", head + "0\nITEM: ENTRIES a b c d e f g h i j k l\n");
  const std::string pairs_of_step = head + "1\nITEM: ENTRIES id1 id2 N\n1 2 2\n";
  CHECK(packing_of(folder, pairs_of_step, three_discs, steps).contacts.size() == 1);
  write_file(folder / "walls", "id1,id2,N\n1,2,1\n");
  CHECK_THROWS_WITH(packing_of(folder, pairs_of_step, three_discs, steps), Contains("12 names are given"));
  steps.wall_columns.clear();
  CHECK_THROWS_WITH(packing_of(folder, pairs_of_step, three_discs, steps),
                    Contains("line 2: a contact of two particles"));
  write_file(folder / "walls", "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ENTRIES\n0\n");
  CHECK_THROWS_WITH(packing_of(folder, pairs_of_step, three_discs, steps), Contains("there is no step 5 among"));
}

TEST_CASE("Particles and walls are those of the step of the contacts, whether it is asked for or the last one") {
  const test::TemporaryFolder folder;
  const std::string contacts = "frame,id1,id2,N\n1,1,2,2\n2,1,2,3\n";
  const std::string particles = "frame,id,x,y,radius\n1,1,0,0,0.5\n1,2,1,0,0.5\n2,1,0,0,0.5\n2,2,1.1,0,0.5\n";
  PackingFiles files;
  files.walls = folder / "walls";
  write_file(files.walls, "frame,id1,contact_x,contact_y,N\n1,1,0,-0.5,4\n3,1,0,-0.5,9\n");
  const Packing last = packing_of(folder, contacts, particles + "3,1,0,0,0.5\n3,2,7,0,0.5\n", files);
  REQUIRE(last.contacts.size() == 1);  // no particle touches a wall
  CHECK(last.contacts[0].branch_x == 1.1);
  CHECK(last.step == 2.0);
  CHECK(last.steps == 2);
  const Packing first = packing_of(folder, contacts, particles, files, 1);
  REQUIRE(first.contacts.size() == 2);
  CHECK(first.contacts[0].branch_x == 1);
  CHECK(first.contacts[1].N == 4);
  // Walls without frames are of all steps.
  write_file(files.walls, "id1,contact_x,contact_y,N\n2,1,-0.5,4\n");
  for (const double step : {1, 2}) CHECK(packing_of(folder, contacts, particles, files, step).contacts.size() == 2);
  const auto dump = [](int step, const char* columns, const std::string& line) {
    return "ITEM: TIMESTEP\n" + std::to_string(step) + "\nITEM: NUMBER OF LINES\n1\nITEM: LINES " + columns + '\n' +
           line + '\n';
  };
  const std::string one = dump(1, "id1 id2 N", "1 -1 2"), positions = dump(1, "id x y", "1 5 5");
  CHECK(packing_of(folder, one, positions + dump(2, "id x y", "1 9 9")).particles[0].x == 5);
}

TEST_CASE("Contacts with walls may have no force, and are no contacts whose particles are not told") {
  const test::TemporaryFolder folder;
  PackingFiles files;
  files.walls = folder / "walls";
  write_file(files.walls, "id1,contact_x,contact_y,N\n1,0,0,0\n2,1,-0.5,0\n");  // the first touches none
  const Packing packing = packing_of(folder, "id1 id2 N\n1 2 2\n", three_discs, files);
  REQUIRE(packing.contacts.size() == 2);
  CHECK(packing.contacts[1].branch_y == -1);
  const std::string unnamed = "x1,y1,x2,y2,N\n0,0,1,0,1\n";
  write_file(files.walls, unnamed);
  CHECK_THROWS_WITH(packing_of(folder, unnamed, "", files),
                    Contains("line 2: a contact of two particles, or of unnam"));
}

TEST_CASE("Positions of PeGS without frames have y counting down, too") {
  const test::TemporaryFolder folder;
  const Packing packing = packing_of(folder, "id1 id2 N T\n1 2 2 0\n", "1,0,5,0.5,0\n2,0,4,0.5,0\n");
  CHECK(packing.particles[0].y == -5);
  CHECK(packing.contacts[0].branch_y == 1);
}

TEST_CASE("Names of columns may stand in any comment above the numbers") {
  const test::TemporaryFolder folder;
  const Packing packing = packing_of(folder, "# run 7\n# id1 id2 N T\n1 2 2 0.5\n", three_discs);
  CHECK(packing.contacts[0].T == 0.5);
  PackingFiles numbered;
  numbered.columns = {"id1=particle # a", "id2=particle # b"};
  const std::string names = "particle # a,particle # b,N,T\n";
  CHECK(packing_of(folder, names + "1,2,2,0.5 # first\n", three_discs, numbered).contacts[0].T == 0.5);
}

TEST_CASE("Distributions of contacts have the counts of the file, and sums on particles say who is off balance") {
  const test::TemporaryFolder folder;
  const Packing packing = packing_of(folder, "id1 id2 N T\n1 2 2 0\n2 3 2 0.5\n3 4 2 -0.4\n",
                                     "id x y radius\n1 0 0 0.5\n2 1 0 0.5\n3 2 0 0.5\n4 2 1 0.5\n");
  const auto direction = distribution(packing, Distributed::direction, 0.5);
  REQUIRE(direction.size() == 18);
  CHECK(direction[0].density == Approx(2.0 / 3 / 10));  // two along x, one along y
  CHECK(direction[9].density == Approx(1.0 / 3 / 10));
  const auto friction = distribution(packing, Distributed::friction, 0.5);
  REQUIRE(friction.size() == 11);
  CHECK(friction[0].density == Approx(1 / 3.0 / 0.05));
  CHECK(friction[10].density == Approx(1 / 3.0 / 0.05));  // 0.5 of 0.5 * 2
  CHECK(friction[10].standard_error == Approx(1 / 3.0 / 0.05));
  const auto sums = forces_on_particles(packing);
  CHECK(sums[1].contacts == 2);
  CHECK(sums[1].x == Approx(0).margin(1e-15));
  CHECK(sums[1].y == Approx(-0.5));
  CHECK(sums[1].torque == Approx(-0.25));
}

TEST_CASE("A contact across the seam is drawn in halves, a sliding one has a mark, one that pulls is off the cone") {
  const test::TemporaryFolder folder;
  PackingFiles files;
  files.periods = {3.0, std::nullopt};
  SceneSpec spec;
  spec.coordinates = Coordinates::packing;
  const auto bars_of = [](const Scene& scene) {
    std::vector<Element> bars;
    scene.elements(scene.extent, [&](const Element& one) {
      if (one.x0 != one.x1) bars.push_back(one);
    });
    return bars;
  };
  const Packing ring = packing_of(folder, "id1 id2 N T\n1 2 1 0\n2 3 1 0\n3 1 1 0.3\n",
                                  "id x y radius\n1 0 0 0.5\n2 1 0 0.5\n3 2 0 0.5\n", files);
  const Scene scene = build_packing_scene(ring, 0.3, spec);
  CHECK(scene.counts.drawn == 3);
  CHECK(scene.extent.x0 == -0.5);
  CHECK(scene.extent.x1 == 2.5);
  CHECK(bars_of(scene).size() == 4);
  int marks = 0;
  scene.elements(scene.extent, [&](const Element& one) { marks += one.level == solid_line_level ? 1 : 0; });
  CHECK(marks == 2);  // on either half
  CHECK(build_packing_scene(ring, std::nan(""), spec).values.most_levels == 255);
  spec.scene = "friction";
  const Packing loose = packing_of(folder, "id1 id2 N T\n1 2 3 0\n2 3 -1 0.1\n", three_discs);
  const auto bars = bars_of(build_packing_scene(loose, 0.3, spec));
  REQUIRE(bars.size() == 1);
  CHECK(bars[0].level == 255);
}

TEST_CASE("A contact across the seam of a periodic box has the branch to the nearest image") {
  const test::TemporaryFolder folder;
  PackingFiles files;
  files.periods = {3.0, std::nullopt};
  const Packing packing = packing_of(folder, "id1 id2 N\n1 2 1\n2 3 1\n3 1 1\n", three_discs, files);
  for (const PackingContact& one : packing.contacts) CHECK(one.branch_x == Approx(1));
  CHECK(numbers_of(packing)["balance_max"] == Approx(0).margin(1e-14));
}

TEST_CASE("Packings without forces, and those that only pull, have numbers and pictures") {
  const test::TemporaryFolder folder;
  SceneSpec spec;
  spec.coordinates = Coordinates::packing;
  const Packing still = packing_of(folder, "id1 id2 N T\n1 2 0 0\n2 3 0 0\n", three_discs);
  CHECK(build_packing_scene(still, 0, spec).counts.too_faint == 2);
  CHECK(distribution(still, Distributed::normal_force, 0).empty());
  CHECK(std::isnan(numbers_of(still)["stress_angle"]));
  const Packing mixed = packing_of(folder, "id1 id2 N T\n1 2 3 0\n2 3 -1 0\n", three_discs);
  CHECK(numbers_of(mixed, 0.3)["tension"] == 1);
  CHECK(numbers_of(mixed, 0.3)["cone_violations"] == 1);
  CHECK(numbers_of(mixed, 0.3)["sliding"] == 0);
  const Packing loose = packing_of(folder, "id1 id2 N T\n1 2 3 0\n2 3 0 1\n", three_discs);
  CHECK(std::isnan(numbers_of(loose)["T_over_N_max"]));  // no friction holds what does not press
  const Packing bare = packing_of(folder, "id1 id2 N\n1 2 3\n2 3 1\n");
  CHECK(std::isnan(numbers_of(bare)["mean_diameter"]));
  CHECK(std::isnan(numbers_of(bare)["fabric_angle"]));
  // Contacts that name no particles are not all with walls.
  CHECK(numbers_of(packing_of(folder, "x1,y1,x2,y2,N\n0,0,1,0,1\n1,0,2,0,1\n"))["wall_contacts"] == 0);
  // A box that is periodic and does not say so.
  const Packing around =
      packing_of(folder, "id1 id2 N\n1 2 1\n2 3 1\n3 1 1\n", "id x y radius\n1 0 0 0.5\n2 1 0 0.5\n3 7 0 0.5\n");
  REQUIRE_FALSE(around.told.empty());
  CHECK_THAT(around.told.back(), Contains("--period-x"));
  // Where no file tells how large a particle is, any box may hold it.
  const std::string small_box =
      "ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS pp ff pp\n0 0.1\n0 1\n0 1\n";
  CHECK(packing_of(folder, small_box + "ITEM: ENTRIES id1 id2 N\n1 2 1\n").contacts.size() == 1);
}

TEST_CASE("Each bad line of contacts is told with its number, all together, up to some") {
  const test::TemporaryFolder folder;
  struct Bad {
    std::string contacts, particles;
    std::vector<std::string> told;
  };
  const std::string head = "id1,id2,N,T\n1,2,1,0\n";
  const std::vector<Bad> cases{
      {head + "1,9,1,0\n2,3,nan,0\n3,3,1,0\n2,3,x,0\n",
       three_discs,
       {"line 3: there is no particle 9", "line 4: n is no number", "line 5: the particle 3 touches itself",
        "line 6: n is no number"}},
      {head + "2,3,1\n2,3,1,0,5\n", three_discs, {"line 3: 3 cells instead of 4", "line 4: 5 cells instead of 4"}},
      {head + "1,2,1,0\n", three_discs, {"line 3: the contact of 1 and 2 stands in line 2, too"}},
      {head + "2,1,3,0\n2,1,2,0\n", three_discs, {"line 4: the contact of 2 and 1 stands in line 2, too"}},
      {"x1,y1,z1,x2,y2,z2,N\n0,0,0,1,0,0.2,1\n", "", {"line 2: it reaches out of the plane", "y1=z1,y2=z2,fy=fz"}},
      {"x1,y1,x2,y2,fx,fy,fz\n0,0,1,0,1,0,0.2\n", "", {"line 2: it reaches out of the plane"}},
      {head, "id,x,y,z\n1,0,0,0\n2,1,0,1\n3,2,0,0\n", {"--particle-columns y=z"}},
      {"<?xml version=\"1.0\"?>\n<graphml>\n", "", {"it is GraphML"}},
      {head + "1.5,2,1,0\n-4,2,1,0\n", three_discs, {"line 3: the id 1.5", "line 4: the first particle is a wall"}},
      {"x1,y1,x2,y2,N\n0,0,0,0,1\n", "", {"line 2: both particles are at one place"}},
      {"x1,y1,x2,y2,N\n0,0,inf,0,1\n", "", {"line 2: x2 is no number"}},
      {"id1,id2\n1,2\n", three_discs, {"its columns are id1, id2", "normal force N"}},
      {"1 2 3\n4 5 6\n", "", {"its 3 columns have no names", "--columns"}},
      {"N,T\n1,0\n", "", {"needed are id1 and id2, or x1, y1, x2 and y2"}},
      {head, "id,x\n1,0\n", {"id, x and y are needed"}},
      {head, "id,x,y\n1,0,0\n1,1,0\n2,nan,0\n", {"line 3: the particle 1 stands twice", "line 4: x, y or the radius"}},
      {"id1,id2,N,n\n1,2,1,1\n", three_discs, {"two columns are named n"}},
      {"id1 id2 N\n1 2 1,5\n", three_discs, {"line 2: a comma in a number"}},
      {"id1;id2;N;T\n1;2;1,500;0.5\n", three_discs, {"line 2: a comma in a number"}},  // thousands, or decimals
      {"id1;id2;N\n1;2;1,5,5\n", three_discs, {"line 2: n is no number"}},
      {std::string("PK\x03\x04\x14\0", 6), "", {"of a spreadsheet: saved as CSV"}},
      {"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\nITEM: ENTRIES id1 id2 N\n1 2 1\n2 3 1\n",
       three_discs,
       {"line 7: the step is to have 1 line, and goes on"}},
      {"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS xy xz yz pp pp pp\n0 13 3\n0 9 0\n0 1 0\n"
       "ITEM: ENTRIES id1 id2 N\n1 2 1\n",
       three_discs,
       {"line 6: the box is tilted"}},
      {"ITEM: TIMESTEP\n8\nITEM: NUMBER OF ENTRIES\n0\nITEM: ENTRIES id1 id2 N\n",
       three_discs,
       {"step 8; --step takes"}},
      {"", "", {"there is no line of numbers"}},
      {"x1,y1,x2,y2,N,T,fx,fy\n0,0,1,0,3,4,5,0\n0,1,1,1,3,4,0,6\n",
       "",
       {"line 3: N and T make a force of 5, fx and fy"}},
      {"# nothing\n\n", "", {"there is no line of numbers"}},
      {std::string("a\0b", 3), "", {"it is no text"}},
      {std::string("\xff\xfei\0d\0", 6), "", {"it is in UTF-16"}},
      {"id1,id2,N\n1,2,\u22125\n", three_discs, {"line 2: the sign U+2212"}},
      {"\x89HDF\r\n", "", {"granuscope export"}},
      {"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n3\nITEM: ENTRIES id1 id2 N\n1 2 1\n",
       three_discs,
       {"the step is to have 3 lines, and has 1"}},
      {"ITEM: NOTHING\n", "", {"no ITEM: TIMESTEP"}},
      {"ITEM: TIMESTEP\nx\nITEM: NUMBER OF ENTRIES\n1\n", "", {"line 2: this is to be the number of a step"}},
      {"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n-3\nITEM: ENTRIES id1 id2 N\n1 2 1\n",
       three_discs,
       {"line 4: this is to be how many lines the step has"}},
      {"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS pp pp pp\n3 0\n0 9\n0 1\n"
       "ITEM: ENTRIES id1 id2 N\n1 2 1\n",
       three_discs,
       {"line 6: these are to be the lower and the upper bound"}},
      {"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS pp", "", {"line 5: the step ends before"}},
      {"ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS pp pp pp\n0 0.7\n0 9\n0 1\n"
       "ITEM: ENTRIES id1 id2 N\n1 2 1\n",
       three_discs,
       {"a period of 0.7, which is less than a particle of 1 across"}},
      {"id1,id2,N\n1,2,1e308\n2,3,1e308\n", three_discs, {"line 2: n is no number below 10^100"}},
      {head, "id,x,y\n1,0,0\n2,1e300,0\n", {"line 3: x, y or the radius is no number"}},
      {"frame,id1,id2,N\n1,1,2,1\nnan,2,3,1\n2,1,2,1\n", three_discs, {"line 3: the frame is no number"}},
  };
  for (const Bad& bad : cases) {
    INFO(bad.contacts);
    for (const std::string& told : bad.told) {
      CHECK_THROWS_WITH(packing_of(folder, bad.contacts, bad.particles), Contains(told));
    }
  }
  std::string many = head;
  for (int k = 0; k < 100; ++k) many += "1,77,1,0\n";
  CHECK_THROWS_WITH(packing_of(folder, many, three_discs), Contains("95 more lines"));
  CHECK_THROWS_WITH(packing_of(folder, "frame,id1,id2,N\n1,1,2,1\n", three_discs, {}, 4), Contains("no frame 4"));
}

TEST_CASE("A long step of a dump, and a long table, are the same read by several threads or line by line") {
  const test::TemporaryFolder folder;
  const int lines = 150'000;
  std::string rows;
  for (int k = 0; k < lines; ++k)
    rows += std::to_string(k + 1) + " " + std::to_string(k + 2) + " " + std::to_string(1 + 0.001 * k) + "\n";
  const std::string head = "ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n150000\nITEM: ENTRIES id1 id2 N\n";
  const auto read = [&](const std::string& text) {
    write_file(folder / "dump", text);
    return NumberFile(folder / "dump", {}, TableOf::contacts).read({});
  };
  // A remark in the middle of a table, or an empty line at its end, makes it be read line by line.
  const auto dump = read(head + rows), with_remark = read("id1 id2 N\n# made by hand\n" + rows),
             table = read("id1 id2 N\n" + rows), with_end = read("id1 id2 N\n" + rows + "\n");
  CHECK(with_remark->rows() == static_cast<std::size_t>(lines));
  CHECK(with_remark->at(lines - 1, 2) == Approx(150.999));
  for (const auto& one : {dump, table, with_end}) CHECK(one->numbers == with_remark->numbers);
  CHECK(table->lines == with_end->lines);
  CHECK_THROWS_WITH(read("id1 id2 N\n" + rows + "ITEM: 2\n"), Contains("line 150002: 2 cells instead of 3"));
  CHECK(dump->lines.front() == 6);
  CHECK(dump->lines.back() == static_cast<std::size_t>(lines) + 5);
  // What is wrong is told in the order of the file, whichever thread has seen it; then how much more there is.
  std::string wrong = rows;
  for (const int line : {140'000, 90'000, 20'000, 10'000, 4000, 2})
    wrong.insert(wrong.find("\n" + std::to_string(line) + " ") + 1, "7 7 7 ");
  try {
    read(head + wrong);
    FAIL("it was read");
  } catch (const InputError& error) {
    std::size_t from = 0;
    for (const char* told :
         {"line 7: 6 cells instead of 3", "line 4005", "line 10005", "line 20005", "line 90005", "1 more line"}) {
      INFO(error.what());
      from = std::string(error.what()).find(told, from);
      CHECK(from != std::string::npos);
    }
  }
}

TEST_CASE("A scene of a packing hands over each bar once, and all that reach into a region") {
  Packing packing;
  packing.mean_diameter = 2;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-40, 40), angle(0, 6.283);
  for (int k = 0; k < 400; ++k) {
    packing.particles.push_back({k, place(random), place(random), 0.6 + 0.001 * k});
    PackingContact one;
    one.first = static_cast<std::size_t>(k);
    one.placed = k % 10 != 0;
    one.x = packing.particles.back().x;
    one.y = packing.particles.back().y;
    const double along = angle(random);
    one.branch_x = 2 * std::cos(along);
    one.branch_y = 2 * std::sin(along);
    one.N = 0.01 * k;
    packing.contacts.push_back(one);
  }
  SceneSpec spec;
  spec.coordinates = Coordinates::packing;
  for (const bool windowed : {false, true}) {
    if (windowed) spec.window = {{-5, 7, -3, 11}};
    const Scene scene = build_packing_scene(packing, 0, spec);
    const SceneCounts& counts = scene.counts;
    CHECK(counts.drawn + counts.outside + counts.too_faint == 400);
    std::vector<Element> all;
    const Extent everything{-1e9, 1e9, -1e9, 1e9};
    scene.elements(everything, [&](const Element& one) { all.push_back(one); });
    std::size_t bars = 0;
    for (const Element& one : all) bars += one.x0 != one.x1 || one.z0 != one.z1 ? 1 : 0;
    CHECK(bars == counts.drawn);
    if (windowed) CHECK(counts.outside > 40);
    for (int trial = 0; trial < 50; ++trial) {
      const double x = place(random) / 2, z = place(random) / 2;
      const Extent region{x, x + 3, z, z + 0.5};
      std::size_t wanted = 0, met = 0;
      for (const Element& one : all) {
        const double reach = one.width / 2;
        wanted += std::max(one.x0, one.x1) + reach >= region.x0 && std::min(one.x0, one.x1) - reach <= region.x1 &&
                          std::max(one.z0, one.z1) + reach >= region.z0 && std::min(one.z0, one.z1) - reach <= region.z1
                      ? 1
                      : 0;
      }
      scene.elements(region, [&](const Element& one) {
        const double reach = one.width / 2;
        met += std::max(one.z0, one.z1) + reach >= region.z0 && std::min(one.z0, one.z1) - reach <= region.z1 ? 1 : 0;
      });
      CHECK(met == wanted);
    }
  }
  spec.window = {{100, 110, 0, 10}};
  CHECK_THROWS_WITH(build_packing_scene(packing, 0, spec), Contains("beside the packing, which reaches from -2"));
  spec.scene = "friction";
  CHECK_THROWS_WITH(build_packing_scene(packing, std::nan(""), spec), Contains("--mu"));
  spec.scene = "weight";
  CHECK_THROWS_WITH(build_packing_scene(packing, 0.3, spec), Contains("choose forces or friction"));
}

TEST_CASE("A film has one window and one colour scale over all steps that have contacts") {
  const test::TemporaryFolder folder;
  std::string dump;
  const auto add_step = [&](int step, const std::vector<std::string>& lines) {
    dump += "ITEM: TIMESTEP\n" + std::to_string(step) + "\nITEM: NUMBER OF ENTRIES\n" + std::to_string(lines.size()) +
            "\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ENTRIES x1 y1 z1 x2 y2 z2 id1 id2 periodic fx fy fz\n";
    for (const std::string& line : lines) dump += line + '\n';
  };
  add_step(0, {});
  add_step(100, {"0 0 0 1 0 0 1 2 0 1 0 0"});
  add_step(200, {"0 0 0 1.1 0 0 1 2 0 3 0 0", "1.1 0 0 5 0 0 2 3 0 8 0 0"});
  write_file(folder / "dump", dump);
  const auto source_of = [&](const char* name) {
    PackingFiles files;
    files.contacts = folder / name;
    return PackingSource(files);
  };
  const PackingSource source = source_of("dump");
  CHECK(source.steps() == std::vector<double>{100, 200});
  SceneSpec spec;
  spec.coordinates = Coordinates::packing;
  const PackingFilm film(source, std::nan(""), spec);
  REQUIRE(film.frames() == 2);
  const Scene first = film.scene(0), second = film.scene(1);
  CHECK(first.extent.x1 == second.extent.x1);
  CHECK(first.extent.x1 == 5.5);  // in diameters of the first step
  CHECK(first.plot_height_px == second.plot_height_px);
  CHECK(first.values.high == second.values.high);
  CHECK(second.value_max == 2);  // 8 over the mean of 1, 3 and 8
  std::vector<std::uint8_t> levels;
  for (const Scene& scene : {first, second}) {
    scene.elements({-9, 9, -9, 9}, [&](const Element& one) { levels.push_back(one.level); });
  }
  REQUIRE(levels.size() == 3);
  std::sort(levels.begin() + 1, levels.end());  // thick bars may be met first
  CHECK(levels[0] < levels[1]);
  CHECK(levels[1] < levels[2]);
  CHECK_THAT(second.key_title, Contains("step 200"));
  write_file(folder / "table", "frame,x1,y1,x2,y2,N\n2,0,0,1,0,1\n7,0,0,1,0,2\n");
  CHECK(PackingFilm(source_of("table"), 0, spec).frames() == 2);
  write_file(folder / "table", "x1,y1,x2,y2,N\n0,0,1,0,1\n");
  CHECK_THROWS_WITH(PackingFilm(source_of("table"), 0, spec), Contains("one step"));
}

TEST_CASE("Lines of VTK are contacts, whose points are the particles") {
  const test::TemporaryFolder folder;
  const std::string legacy =
      "# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET POLYDATA\nPOINTS 5 float\n"
      "0 0 0 1 0 0 1 0 0 2 0 0 7 7 7\nLINES 2 6\n2 0 1\n2 2 3\nCELL_DATA 2\n"
      "SCALARS forceN float 1\nLOOKUP_TABLE default\n2 2\nVECTORS force float\n2 0 0 2 0.5 0\n"
      "FIELD more 1\nabsForceT 1 2 float\n0 0.5\n";
  const Packing packing = packing_of(folder, legacy);
  REQUIRE(packing.contacts.size() == 2);
  CHECK(packing.contacts[1].N == 2);
  CHECK(packing.contacts[1].T == 0.5);
  CHECK(numbers_of(packing)["particles"] == 3);  // two of the points are at one place
  CHECK(numbers_of(packing)["rattlers"] == 2);
  // Upright, and with a name of its own for the normal force.
  PackingFiles named;
  named.columns = {"N=press"};
  const std::string upright =
      "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"2\" "
      "NumberOfLines=\"1\">"
      "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 5 0 0 5 1</DataArray></Points>"
      "<CellData><DataArray type=\"Float32\" Name=\"press\" format=\"ascii\">4</DataArray></CellData><Lines>"
      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1</DataArray>"
      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">2</DataArray></Lines></Piece></PolyData></VTKFile>";
  const Packing standing = packing_of(folder, upright, "", named);
  REQUIRE(standing.contacts.size() == 1);
  CHECK(standing.contacts[0].branch_y == 1);
  CHECK(standing.contacts[0].N == 4);
  const auto changed = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  for (const auto& [text, told] : std::vector<std::pair<std::string, std::string>>{
           {changed(legacy, "2 2\nVECTORS", "2 nan\nVECTORS"), "cell 1: forcen is no number"},
           {changed(legacy, "2 2\nVECTORS", "2 x\nVECTORS"), "forcen has fewer numbers"},
           {changed(legacy, "2 2\nVECTORS", "2 9\nVECTORS"), "cell 1: N and T make a force of 9.01388"},
           {changed(legacy, "2 2 3", "2 2 9"), "cell 1 has a point 9 of 5"},
           {changed(legacy, "2 2 3", "2 2 2"), "cell 1: the particle 1 touches itself"},
           {changed(legacy, "LINES 2 6\n2 0 1\n2 2 3", "VERTICES 2 4\n1 0\n1 1"), "no line of two points"},
           {changed(legacy, "POLYDATA", "RECTILINEAR_GRID"), "'rectilinear_grid' is not known"},
           {changed(upright, "PolyData", "ImageData"), "it is ImageData of VTK"},
           {changed(upright, ">4<", "><"), "press has 0 numbers for 1 cells"},
           {upright, "needed are the normal force N"}}) {
    INFO(text);
    CHECK_THROWS_WITH(packing_of(folder, text), Contains(told));
  }
  // Blocks that unpack to much more than the file has: each may, all together are refused before any is unpacked.
  const auto packed = [&](std::uint32_t blocks, std::uint32_t bytes) {
    std::string head;
    for (std::uint32_t k = 0; k < blocks + 3; ++k) {
      for (int byte = 0; byte < 4; ++byte)
        head += static_cast<char>((k == 0 ? blocks : k == 1 ? bytes : 0U) >> 8 * byte);
    }
    const std::string points = "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"";
    std::string text = changed(upright, "type=\"PolyData\"", "type=\"PolyData\" compressor=\"vtkZLibDataCompressor\"");
    text = changed(text, points + "ascii\">0 5 0 0 5 1", points + "appended\" offset=\"0\">");
    return changed(text, "</VTKFile>", "<AppendedData encoding=\"raw\">_" + head + std::string(20'000, ' '));
  };
  CHECK_THROWS_WITH(packing_of(folder, packed(200, 20'000'000)), Contains("larger than 2 GB"));
  CHECK_THROWS_WITH(packing_of(folder, packed(20, 20'000)), Contains("fewer numbers"));
  PackingFiles unknown;
  unknown.columns = {"N=pressure"};
  CHECK_THROWS_WITH(packing_of(folder, upright, "", unknown), Contains("of the columns x1, y1") && Contains("press"));
}

TEST_CASE("The distribution of normal forces adds up to one, and counts its errors") {
  Packing packing;
  std::mt19937 random(2);
  std::exponential_distribution<double> force(0.25);
  for (int k = 0; k < 20000; ++k) {
    PackingContact one;
    one.N = force(random);
    packing.contacts.push_back(one);
  }
  double sum = 0, chi2 = 0;
  for (const ForceBin& bin : distribution(packing, Distributed::normal_force, 0)) {
    sum += bin.density * (bin.to - bin.from);
    if (bin.to > 3.05) continue;
    const double expected = (std::exp(-bin.from) - std::exp(-bin.to)) / (bin.to - bin.from);
    chi2 += std::pow((bin.density - expected) / bin.standard_error, 2);
  }
  CHECK(sum == Approx(1).margin(1e-3));  // one in 22026 lies beyond ten means
  CHECK(chi2 < 60);                      // 30 bins
}
