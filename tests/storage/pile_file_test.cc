#include "storage/pile_file.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <limits>
#include <mutex>
#include <thread>

#include "kit/file_size_limit.h"
#include "kit/sanitized.h"
#include "kit/standard_error_capture.h"
#include "kit/temporary_folder.h"
#include "storage/ensemble_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using namespace granuscope::test;
using Catch::Matchers::Contains;

TEST_CASE("a pile comes back bit by bit") {
  const TemporaryFolder folder;
  for (const auto& [layers, columns] : {std::pair{1, 4}, {3, 5}, {37, 64}}) {
    Pile pile = awkward_pile(layers, columns);
    for (const LoadLine& line : {LoadLine{}, LoadLine{0.1, -0.05}}) {
      pile.load_line = line;
      pile.bead_weight = line.slope;
      write_pile(folder / "pile.h5", pile);
      const Pile read = read_pile(folder / "pile.h5");
      check_same(read, pile);
      CHECK(read.load_line == line);
      CHECK(read.bead_weight == line.slope);
    }
  }
  CHECK(folder.contents() == std::vector<std::string>{"pile.h5"});
}

TEST_CASE("a pile file keeps the angle of the contacts, and has no word of it at 30 degrees") {
  const TemporaryFolder folder;
  for (const double angle : {30.0, 45.0}) {
    Pile pile = awkward_pile(3, 5);
    pile.lattice = Lattice({.columns = 5, .layers = 3, .angle = angle});
    write_pile(folder / "pile.h5", pile);
    CHECK(read_pile(folder / "pile.h5").lattice.geometry().angle == angle);
    CHECK((read_file(folder / "pile.h5").find("contact_angle") == std::string::npos) == (angle == 30));
  }
}

TEST_CASE("a part of a pile is read alone, and without its horizontal forces where they are not asked for") {
  const TemporaryFolder folder;
  const Pile pile = awkward_pile(6, 7);
  write_pile(folder / "a.h5", pile);
  const int columns = pile.lattice.columns();
  const auto part = read_pile_part(folder / "a.h5", [&](const Lattice& lattice) {
    return PileRange{1, lattice.layers() - 1, columns - 2, 3, false};
  });
  CHECK(part.H_R.empty());
  CHECK(part.H_L.empty());
  const PileView view = view_of(part);
  for (int layer = 1; layer < pile.lattice.layers(); ++layer) {
    for (const int bead : {columns - 2, columns - 1, 0}) {
      CHECK(view.V_R[view.index(layer, bead)] == pile.V_R[pile.lattice.index(layer, bead)]);
      CHECK(view.V_L[view.index(layer, bead)] == pile.V_L[pile.lattice.index(layer, bead)]);
    }
  }
}

TEST_CASE("layers are read band by band, and are those of the pile wherever one looks first") {
  const TemporaryFolder folder;
  const Pile pile = awkward_pile(3 * band_layers, 6);
  write_pile(folder / "a.h5", pile);
  const int first = 7, layers = 3 * band_layers - 11;
  const auto all = open_pile_layers(
      folder / "a.h5",
      [&](const Lattice&) {
        return PileRange{first, layers, 4, 5};
      },
      0);
  CHECK(all->about().load.size() == 6);
  CHECK(all->about().V_R.empty());
  const std::vector<std::pair<int, int>> looks = {
      {first, first}, {first, first + band_layers}, {900, 940}, {60, 61}, {first + layers - 1, first + layers - 1}};
  for (const auto& [from, to] : looks) {
    const PileView& view = all->hold(from, to);
    CHECK(view.range.layers <= band_layers + 1);
    for (int layer = from; layer <= to; ++layer) {
      for (const int bead : {4, 5, 0, 1, 2}) {
        CHECK(view.V_R[view.index(layer, bead)] == pile.V_R[pile.lattice.index(layer, bead)]);
        CHECK(view.H_L[view.index(layer, bead)] == pile.H_L[pile.lattice.index(layer, bead)]);
      }
    }
  }
}

TEST_CASE("the same pile gives the same bytes at any time, under any name") {
  const TemporaryFolder folder;
  const Pile pile = awkward_pile(6, 7);
  write_pile(folder / "first.h5", pile);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // HDF5's times count seconds
  make_folder(folder / "elsewhere");
  write_pile(folder / "elsewhere/second file.h5", pile);
  CHECK(read_file(folder / "first.h5") == read_file(folder / "elsewhere/second file.h5"));
}

TEST_CASE("another pile gives other bytes") {
  const TemporaryFolder folder;
  Pile pile = awkward_pile(6, 7);
  write_pile(folder / "first.h5", pile);
  pile.sample += 1;
  write_pile(folder / "second.h5", pile);
  CHECK(read_file(folder / "first.h5") != read_file(folder / "second.h5"));
}

TEST_CASE("a pile file takes little more than its numbers") {
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(100, 100));
  CHECK(std::filesystem::file_size(folder / "pile.h5") < 4 * 100 * 100 * 8 + 100 * 8 + 8192);
}

TEST_CASE("what is not a pile file is refused with its name and the reason, and HDF5 keeps silent") {
  const TemporaryFolder folder;
  const StandardErrorCapture capture;
  const auto message = [&folder](const std::string& name) {
    std::string text = input_error_of([&] { (void)read_pile(folder / name); });
    CHECK_THAT(text, Contains((folder / name).string()));
    return text;
  };
  CHECK_THAT(message("missing.h5"), Contains("No such file or directory"));

  make_folder(folder / "folder.h5");
  CHECK_THAT(message("folder.h5"), Contains("Is a directory") && !Contains("Piles"));
  make_folder(folder / "folder.h5/piles");  // as of a run
  CHECK_THAT(message("folder.h5"), Contains("Piles of a run lie in " + (folder / "folder.h5/piles").string()));

  write_file(folder / "empty.h5", "");
  CHECK_THAT(message("empty.h5"), Contains("it is empty"));

  write_file(folder / "text.h5", "mu = 0.1\n");
  CHECK_THAT(message("text.h5"), Contains("not an HDF5 file") && Contains("Name a pile file"));

  write_file(folder / "signature.h5", "\x89HDF\r\n\x1a\n");
  CHECK_THAT(message("signature.h5"), Contains("damaged or cut short"));

  write_ensemble(folder / "ensemble.h5", awkward_ensemble());
  CHECK_THAT(message("ensemble.h5"), Contains("it is a granuscope ensemble file"));

  write_pile(folder / "pile.h5", awkward_pile(20, 20));
  const std::string bytes = read_file(folder / "pile.h5");
  write_file(folder / "cut.h5", std::string_view(bytes).substr(0, bytes.size() - 1));
  CHECK_THAT(message("cut.h5"), Contains("damaged or cut short"));
  write_file(folder / "half.h5", std::string_view(bytes).substr(0, bytes.size() / 2));
  CHECK_THAT(message("half.h5"), Contains("damaged or cut short"));

  CHECK(capture.text().empty());
}

TEST_CASE("numbers that are not finite are refused where they are") {
  const TemporaryFolder folder;
  Pile pile = awkward_pile(5, 6);
  SECTION("a force") {
    pile.H_L[pile.lattice.index(3, 2)] = std::numeric_limits<double>::quiet_NaN();
    write_pile(folder / "pile.h5", pile);
    CHECK_THAT(input_error_of([&] { (void)read_pile(folder / "pile.h5"); }), Contains("'/H_L' at [3, 2] is nan"));
  }
  SECTION("a load") {
    pile.load[5] = -std::numeric_limits<double>::infinity();
    write_pile(folder / "pile.h5", pile);
    CHECK_THAT(input_error_of([&] { (void)read_pile(folder / "pile.h5"); }), Contains("'/load' at [5] is infinite"));
  }
  SECTION("mu") {
    pile.mu = std::numeric_limits<double>::quiet_NaN();
    write_pile(folder / "pile.h5", pile);
    CHECK_THAT(input_error_of([&] { (void)read_pile(folder / "pile.h5"); }), Contains("'mu'"));
  }
}

TEST_CASE("a full disk keeps the old pile") {
  const TemporaryFolder folder;
  const Pile old = awkward_pile(4, 4);
  write_pile(folder / "pile.h5", old);
  {
    const FileSizeLimit limit(20'000);
    CHECK_THROWS_AS(write_pile(folder / "pile.h5", awkward_pile(100, 100)), EnvironmentError);
  }
  CHECK_THROWS_AS(write_pile(folder / "missing/pile.h5", old), EnvironmentError);
  CHECK(folder.contents() == std::vector<std::string>{"pile.h5"});
  check_same(read_pile(folder / "pile.h5"), old);
}

TEST_CASE("several threads may read and write at once") {
  const TemporaryFolder folder;
  const Pile pile = awkward_pile(10, 10);
  write_pile(folder / "shared.h5", pile);
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::atomic<int> good{0};
  // A file is read in a child of this process. The sanitizer's memory may be locked by another thread when the child is
  // made, and then stays locked in it for ever (the C library's own does not): there, one thread at a time.
  std::mutex one_at_a_time;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 20; ++i) {
        std::unique_lock lock(one_at_a_time, std::defer_lock);
        if (test::sanitized) lock.lock();
        write_pile(folder / std::to_string(t), pile);
        const bool same = same_bytes(read_pile(folder / std::to_string(t)).V_R, pile.V_R);
        if (same && same_bytes(read_pile(folder / "shared.h5").H_L, pile.H_L)) ++good;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(good == 80);
}
