#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "render/render_pile.h"

namespace granuscope {

/// One picture of the suite.
struct RenderCase {
  std::string name;
  int columns = 0, layers = 0;  ///< of the pile, mu = 0.3 under an overload
  SceneSpec spec;
};

/// What it took, in a process of its own; the shortest of several runs.
struct RenderTiming {
  RenderCase picture;
  SceneStatistics statistics;    ///< with the seconds of each step
  double seconds = 0;            ///< from the file to the PNG on disk, wall time; without starting the program
  std::uint64_t peak_bytes = 0;  ///< most memory that the process had
  std::uint64_t image_bytes = 0;
  std::string failure;  ///< why there are no numbers, if so
};

/// A limit that the suite holds its own numbers against.
struct RenderTarget {
  std::string name;
  double measured = 0, limit = 0;
  bool at_most = true;  ///< or at least
  bool met() const { return at_most ? measured <= limit : measured >= limit; }
};

struct RenderBench {
  std::vector<RenderTiming> timings;
  std::vector<RenderTarget> targets;
};

/// Pictures of 70 x 60 to 4000 x 4000 beads at 800 to 8000 pixels, with and without skipping, and a small window of
/// the largest pile. `quick`: without the ones that take minutes.
std::vector<RenderCase> render_cases(bool quick);

/// Renders each case, `say` telling which. Piles and pictures are made in `folder` and removed.
RenderBench run_render_suite(const std::vector<RenderCase>& cases, const std::filesystem::path& folder,
                             const std::function<void(const std::string&)>& say);

/// One JSON object with a final newline.
std::string render_bench_json(const RenderBench& bench);
/// The same as a table for people.
std::string render_bench_table(const RenderBench& bench);

}  // namespace granuscope
