#include "bench/suites.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <exception>

#include "sampling/sampler.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/files.h"

namespace granuscope {
namespace {

// The targets of the suite and the cases they are about.
constexpr const char* large_case = "1000 x 1000 to 2000 px";
constexpr double large_case_seconds = 0.5;
constexpr double large_case_speed_up = 3;
constexpr const char* window_case = "100 x 100 window of 4000 x 4000 to 800 px";
constexpr double window_case_seconds = 0.1;
/// The file has 512 MB, the pixels of the picture would take 226 MB.
constexpr const char* memory_case = "4000 x 4000 to 8000 px";
constexpr double memory_case_megabytes = 160;
constexpr const char* unskipped = ", all drawn";

/// Runs of a case, of which the shortest counts; one if it takes long.
constexpr int repetitions = 3;
constexpr double long_seconds = 5;

std::filesystem::path pile_file(const RenderCase& picture, const std::filesystem::path& folder) {
  return folder / fmt::format("pile-{}x{}.h5", picture.columns, picture.layers);
}

void draw_and_write(const RenderCase& picture, const std::filesystem::path& file) {
  const Lattice lattice({picture.columns, picture.layers});
  Pile pile(lattice);
  std::vector<double> load(static_cast<std::size_t>(picture.columns), 1.0);
  load[static_cast<std::size_t>(lattice.middle())] = 2;
  SamplerSpec spec;
  spec.mu = 0.3;
  if (make_sampler(spec, lattice)->draw(0, load, pile)) {
    throw EnvironmentError("a pile of the suite could not be completed, so there is nothing to render; report this");
  }
  write_pile(file, pile);
}

/// In a process of its own: what a process keeps of a large pile would count as memory of the pictures that it starts.
void make_pile(const RenderCase& picture, const std::filesystem::path& file) {
  const OwnProcess made = in_own_process([&] {
    try {
      draw_and_write(picture, file);
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      throw;
    }
  });
  if (!made.done) {
    throw EnvironmentError("a pile of {} x {} beads could not be made in {}; see whether there is memory and space",
                           picture.columns, picture.layers, file.parent_path().string());
  }
}

/// What the child tells of its run.
struct ChildNumbers {
  double seconds = 0;
  SceneCounts counts;
  SceneStatistics::Seconds steps;
  char renderer[160] = {};
};

/// Renders in a process of its own: its memory is that of this picture alone, and its GL is started anew.
RenderTiming time_once(const RenderCase& picture, const std::filesystem::path& pile,
                       const std::filesystem::path& image) {
  RenderTiming timing;
  timing.picture = picture;
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw EnvironmentError("no pipe to a child process can be made; try again");
  ChildNumbers numbers;
  const OwnProcess rendering = in_own_process([&] {
    const auto start = std::chrono::steady_clock::now();
    const SceneStatistics statistics = render_pile_file({pile, {}, image}, picture.spec);
    numbers.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    numbers.counts = statistics.counts;
    numbers.steps = statistics.seconds;
    statistics.renderer.copy(numbers.renderer, sizeof numbers.renderer - 1);
    if (::write(ends[1], &numbers, sizeof numbers) != sizeof numbers) throw EnvironmentError("the pipe is closed");
  });
  ::close(ends[1]);
  const ssize_t got = ::read(ends[0], &numbers, sizeof numbers);  // a pipe holds that much
  ::close(ends[0]);
  if (!rendering.done || got != sizeof numbers) {
    timing.failure = "the picture could not be rendered; do it with granuscope render to see why";
    return timing;
  }
  timing.seconds = numbers.seconds;
  timing.statistics.counts = numbers.counts;
  timing.statistics.seconds = numbers.steps;
  timing.statistics.renderer = numbers.renderer;
  timing.peak_bytes = static_cast<std::uint64_t>(rendering.peak_bytes);
  timing.image_bytes = std::filesystem::file_size(image);
  return timing;
}

const RenderTiming* find(const RenderBench& bench, const std::string& name) {
  const auto found = std::ranges::find_if(
      bench.timings, [&](const RenderTiming& timing) { return timing.picture.name == name && timing.failure.empty(); });
  return found == bench.timings.end() ? nullptr : &*found;
}

void add_targets(RenderBench& bench) {
  const RenderTiming* large = find(bench, large_case);
  const RenderTiming* large_unskipped = find(bench, std::string(large_case) + unskipped);
  if (large != nullptr)
    bench.targets.push_back({std::string(large_case) + ", seconds", large->seconds, large_case_seconds});
  if (large != nullptr && large_unskipped != nullptr) {
    bench.targets.push_back({std::string(large_case) + ", times faster with skipping",
                             large_unskipped->seconds / large->seconds, large_case_speed_up, false});
  }
  if (const RenderTiming* window = find(bench, window_case)) {
    bench.targets.push_back({std::string(window_case) + ", seconds", window->seconds, window_case_seconds});
  }
  if (const RenderTiming* whole = find(bench, memory_case)) {
    bench.targets.push_back(
        {std::string(memory_case) + ", peak MB", static_cast<double>(whole->peak_bytes) / 1e6, memory_case_megabytes});
  }
}

}  // namespace

std::vector<RenderCase> render_cases(bool quick) {
  std::vector<RenderCase> cases;
  const auto add = [&](int columns, int layers, int width, bool skip) {
    RenderCase picture;
    picture.name = fmt::format("{} x {} to {} px{}", columns, layers, width, skip ? "" : unskipped);
    picture.columns = columns;
    picture.layers = layers;
    picture.spec.width_px = width;
    picture.spec.skip_invisible = skip;
    cases.push_back(picture);
  };
  struct Size {
    int columns, layers;
  };
  for (const Size size : {Size{70, 60}, Size{500, 200}, Size{1000, 1000}, Size{4000, 4000}}) {
    for (const int width : {800, 2000, 8000}) {
      for (const bool skip : {true, false}) {
        if (quick && (size.columns == 4000 || width == 8000)) continue;
        add(size.columns, size.layers, width, skip);
      }
    }
  }
  if (!quick) {
    RenderCase window;
    window.name = window_case;
    window.columns = window.layers = 4000;
    window.spec.width_px = 800;
    window.spec.window = {{-50, 50, 2000, 2099}};
    cases.push_back(window);
  }
  return cases;
}

RenderBench run_render_suite(const std::vector<RenderCase>& cases, const std::filesystem::path& folder,
                             const std::function<void(const std::string&)>& say) {
  RenderBench bench;
  make_folder(folder);
  const std::filesystem::path image = folder / "picture.png";
  for (const RenderCase& picture : cases) {
    const std::filesystem::path pile = pile_file(picture, folder);
    if (!std::filesystem::exists(pile)) {
      say(fmt::format("making a pile of {} x {}", picture.columns, picture.layers));
      make_pile(picture, pile);
    }
    say(picture.name);
    RenderTiming best = time_once(picture, pile, image);
    for (int k = 1; k < repetitions && best.failure.empty() && best.seconds < long_seconds; ++k) {
      const RenderTiming again = time_once(picture, pile, image);
      if (again.failure.empty() && again.seconds < best.seconds) best = again;
    }
    bench.timings.push_back(best);
  }
  for (const RenderCase& picture : cases) std::filesystem::remove(pile_file(picture, folder));
  std::filesystem::remove(image);
  add_targets(bench);
  return bench;
}

std::string render_bench_json(const RenderBench& bench) {
  std::vector<std::string> pictures, targets;
  for (const RenderTiming& timing : bench.timings) {
    std::string entry =
        fmt::format(R"(    {{"name": "{}", "columns": {}, "layers": {}, "width_px": {}, "skipping": {}, )",
                    timing.picture.name, timing.picture.columns, timing.picture.layers, timing.picture.spec.width_px,
                    timing.picture.spec.skip_invisible);
    if (!timing.failure.empty()) {
      pictures.push_back(entry + fmt::format(R"("seconds": null, "reason": "{}"}})", timing.failure));
      continue;
    }
    const SceneCounts& counts = timing.statistics.counts;
    const SceneStatistics::Seconds& steps = timing.statistics.seconds;
    std::string renderer = timing.statistics.renderer;
    std::erase_if(renderer, [](char c) { return c == '"' || c == '\\' || c < ' '; });
    entry += fmt::format(
        R"("seconds": {{"all": {}, "read": {}, "build": {}, "draw": {}, "encode": {}}}, "drawn": {}, "outside": {}, )",
        timing.seconds, steps.read, steps.build, steps.draw, steps.encode, counts.drawn, counts.outside);
    entry += fmt::format(
        R"("too_faint": {}, "aggregated": {}, "pixels": {}, "image_bytes": {}, "peak_bytes": {}, "renderer": "{}"}})",
        counts.too_faint, counts.aggregated, counts.pixels, timing.image_bytes, timing.peak_bytes, renderer);
    pictures.push_back(entry);
  }
  for (const BenchNumber& target : bench.targets) targets.push_back(target.json());
  return fmt::format("{{\n  \"suite\": \"render\",\n  \"pictures\": [\n{}\n  ],\n  \"targets\": [\n{}\n  ]\n}}\n",
                     fmt::join(pictures, ",\n"), fmt::join(targets, ",\n"));
}

std::string render_bench_table(const RenderBench& bench) {
  std::string text = fmt::format("{:<44}{:>8}{:>8}{:>8}{:>8}{:>8}{:>10}\n", "picture", "s", "read", "build", "draw",
                                 "encode", "peak MB");
  for (const RenderTiming& timing : bench.timings) {
    if (!timing.failure.empty()) {
      text += fmt::format("{:<44}{}\n", timing.picture.name, timing.failure);
      continue;
    }
    const SceneStatistics::Seconds& steps = timing.statistics.seconds;
    text +=
        fmt::format("{:<44}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}{:>10.0f}\n", timing.picture.name, timing.seconds,
                    steps.read, steps.build, steps.draw, steps.encode, static_cast<double>(timing.peak_bytes) / 1e6);
  }
  for (const BenchNumber& target : bench.targets) {
    text += fmt::format("{:<4}{}: {:.3f}, {} {:g}\n", target.met() ? "ok" : "--", target.name, target.value,
                        target.at_most ? "at most" : "at least", *target.limit);
  }
  return text;
}

}  // namespace granuscope
