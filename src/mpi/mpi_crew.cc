#include "mpi/mpi_crew.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "experiment/experiment_file.h"
#include "pipeline/block_files.h"
#include "pipeline/shards.h"
#include "storage/byte_record.h"
#include "support/error.h"
#include "support/interruption.h"

namespace granuscope {
namespace fs = std::filesystem;
namespace {

/// Network folders show new files to other machines after this long at the latest (acdirmax of NFS).
constexpr std::chrono::seconds folder_delay{70};
/// A counter beyond the blocks of any experiment: nobody takes another one.
constexpr std::int64_t no_more = std::int64_t{1} << 40;

enum class Command : int { draw, end };

/// One ensemble of an experiment, at the size to which it has grown.
struct Size {
  std::uint64_t ensemble = 0, samples = 0, groups_before = 0;
};

/// What all ranks draw together.
struct Task {
  std::string experiment, folder;
  int threads = 0;
  std::vector<Size> sizes;
  std::vector<Atom> atoms;  ///< dearest first; their ensembles are places in `sizes`
};

template <class Bytes, class TaskType>
void each_field(Bytes& put_or_get, TaskType& task) {
  put_or_get(task.experiment, task.folder, task.threads, task.sizes, task.atoms);
}

std::string to_bytes(const Task& task) {
  ByteWriter writer;
  writer.put(Command::draw);
  const auto put = [&writer](const auto&... field) { (writer.put(field), ...); };
  each_field(put, task);
  return writer.take();
}

/// Threads of this rank: those asked for, or its share of the processors. A rank that is bound to some has these to
/// itself; without, all ranks of a machine share it.
int threads_of(const Ranks& ranks, int asked) {
  if (asked > 0) return asked;
  cpu_set_t bound;
  CPU_ZERO(&bound);
  const int all = static_cast<int>(std::thread::hardware_concurrency());
  const int mine = ::sched_getaffinity(0, sizeof bound, &bound) == 0 ? CPU_COUNT(&bound) : all;
  const long online = ::sysconf(_SC_NPROCESSORS_ONLN);
  return std::max(1, mine < online ? mine : static_cast<int>(online) / ranks.on_this_machine());
}

/// Blocks between the thread that speaks MPI and those that draw.
class Hand {
 public:
  explicit Hand(const std::vector<Atom>& atoms) : atoms_(atoms) {}

  /// A drawing thread asks for work: it waits until there is some or will be no more.
  std::optional<Atom> next() {
    std::unique_lock lock(mutex_);
    ++asked_;
    ++hungry_;
    filled_.wait(lock, [&] { return over_ || !ready_.empty(); });
    --hungry_;
    if (ready_.empty()) return std::nullopt;
    const Atom atom = atoms_[ready_.front()];
    ready_.pop_front();
    return atom;
  }
  bool wants() {
    const std::lock_guard lock(mutex_);
    return !over_ && hungry_ > ready_.size();
  }
  void give(std::size_t index) {
    const std::lock_guard lock(mutex_);
    ready_.push_back(index);
    ++given_;
    filled_.notify_one();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    over_ = true;
    filled_.notify_all();
  }
  /// Blocks that have been drawn: a thread that asks again has finished one.
  std::int64_t finished(int threads) {
    const std::lock_guard lock(mutex_);
    return std::clamp<std::int64_t>(asked_ - threads, 0, given_);
  }
  std::int64_t given() {
    const std::lock_guard lock(mutex_);
    return given_;
  }

 private:
  const std::vector<Atom>& atoms_;
  std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<std::size_t> ready_;
  std::size_t hungry_ = 0;
  std::int64_t asked_ = 0, given_ = 0;
  bool over_ = false;
};

struct Failure {
  int code = 0;
  std::string message;
};

Failure describe(const std::exception_ptr& thrown) {
  if (thrown == nullptr) return {};
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    return {static_cast<int>(error.exit_code()), error.what()};
  } catch (const std::exception& error) {
    return {static_cast<int>(ExitCode::environment), error.what()};
  }
}

[[noreturn]] void rethrow(const Failure& failure) {
  switch (static_cast<ExitCode>(failure.code)) {
    case ExitCode::bad_input:
      throw InputError(failure.message);
    case ExitCode::interrupted:
      throw Interrupted(failure.message);
    default:
      throw EnvironmentError(failure.message);
  }
}

/// Other machines may see a file later than the one that wrote it.
void wait_for_files(const std::vector<PlannedEnsemble>& ensembles, const std::vector<Atom>& atoms,
                    const fs::path& folder) {
  const auto deadline = std::chrono::steady_clock::now() + folder_delay;
  for (const Atom& atom : atoms) {
    const fs::path file = BlockFiles(ensembles[atom.ensemble], folder).file(atom.block);
    std::error_code ignored;
    while (!fs::exists(file, ignored)) {
      throw_if_interrupted();
      if (std::chrono::steady_clock::now() > deadline) {
        throw EnvironmentError(fmt::format(
            "'{}' was written by another rank and is not seen by rank 0, so that the ranks do not share the folder; "
            "choose an --out that all machines see",
            file.string()));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }
}

}  // namespace

void MpiCrew::draw(const Experiment& experiment, const RunOptions& options,
                   const std::vector<PlannedEnsemble>& ensembles) {
  Task task;
  task.experiment = print_experiment(experiment);
  task.folder = fs::absolute(options.folder).string();
  task.threads = options.threads;
  const std::vector<PlannedEnsemble> all = all_ensembles(experiment, {});
  std::vector<PlannedEnsemble> wanted;
  for (const PlannedEnsemble& planned : ensembles) {
    if (planned.reusable) continue;
    const auto same = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.file == planned.file; });
    task.sizes.push_back(
        {static_cast<std::uint64_t>(same - all.begin()), planned.spec.response.samples, planned.groups_before});
    wanted.push_back(planned);
  }
  for (const Atom& atom : atoms_of(wanted)) {
    if (!BlockFiles(wanted[atom.ensemble], options.folder).has(atom.block, options.progress)) {
      task.atoms.push_back(atom);
    }
  }
  if (task.atoms.empty()) return;
  work(ranks_.broadcast(to_bytes(task)), options.progress);
  wait_for_files(wanted, task.atoms, options.folder);
}

void MpiCrew::end(int code) {
  ByteWriter writer;
  writer.put(Command::end);
  writer.put(code);
  ranks_.broadcast(writer.take());
}

int MpiCrew::follow() {
  for (;;) {
    const std::string received = ranks_.broadcast({});
    ByteReader reader(received);
    Command command = Command::end;
    reader.get(command);
    if (command == Command::end) {
      int code = 0;
      reader.get(code);
      return code;
    }
    try {
      work(received, ProgressStyle::silent);
    } catch (const Interrupted&) {
      throw;
    } catch (const Error&) {  // NOLINT(bugprone-empty-catch): all ranks know of it, and rank 0 tells it
    }
  }
}

void MpiCrew::work(const std::string& received, ProgressStyle style) {
  using namespace std::chrono_literals;
  Task task;
  ByteReader reader(received);
  Command command = Command::draw;
  reader.get(command);
  const auto get = [&reader](auto&... field) { (reader.get(field), ...); };
  each_field(get, task);
  const std::vector<PlannedEnsemble> all =
      all_ensembles(parse_experiment(task.experiment, "the experiment of rank 0"), {});
  std::vector<PlannedEnsemble> ensembles;
  for (const Size& size : task.sizes) {
    PlannedEnsemble& one = ensembles.emplace_back(all.at(size.ensemble));
    one.spec.response.samples = size.samples;
    one.groups_before = size.groups_before;
  }
  const fs::path folder = task.folder;
  const int threads = threads_of(ranks_, task.threads);
  ranks_.reset_counters();

  Hand hand(task.atoms);
  std::exception_ptr thrown;
  std::atomic<bool> drawn{false};
  const auto blocks = static_cast<std::int64_t>(task.atoms.size());
  std::optional<Progress> progress;
  if (ranks_.rank() == 0) {
    progress.emplace(fmt::format("drawing on {} ranks, blocks", ranks_.size()), task.atoms.size(), style);
  }
  std::int64_t told = 0, shown = 0;
  const auto tell = [&](std::int64_t finished) {
    if (finished > told) ranks_.add(Ranks::finished, finished - told);
    told = std::max(told, finished);
    if (!progress) return;
    const std::int64_t everywhere = ranks_.add(Ranks::finished, 0);
    progress->advance(static_cast<std::uint64_t>(everywhere - shown));
    shown = everywhere;
  };
  {
    std::jthread drawing([&] {
      try {
        draw_atoms(ensembles, folder, threads, style, nullptr, {}, [&] { return hand.next(); });
      } catch (...) {
        thrown = std::current_exception();
        hand.end();
      }
      drawn = true;
    });
    try {
      for (auto last = std::chrono::steady_clock::now(); !drawn;) {
        if (hand.wants()) {
          const std::int64_t index = ranks_.add(Ranks::taken, 1);
          if (index < blocks) hand.give(static_cast<std::size_t>(index));
          if (index >= blocks) hand.end();
          continue;
        }
        throw_if_interrupted();
        ranks_.attend();
        std::this_thread::sleep_for(500us);
        if (std::chrono::steady_clock::now() - last < 500ms) continue;
        tell(hand.finished(threads));
        last = std::chrono::steady_clock::now();
      }
    } catch (...) {
      hand.end();
      throw;  // the drawing ends first, at its next look for an interruption
    }
  }
  const Failure mine = describe(thrown);
  if (mine.code != 0) {
    ranks_.add(Ranks::taken, no_more);
  } else {
    tell(hand.given());
  }
  if (const int code = ranks_.largest(mine.code); code != 0) {
    const int whose = ranks_.smallest(mine.code == code ? ranks_.rank() : ranks_.size());
    rethrow({code, fmt::format("{}", ranks_.broadcast(mine.message, whose))});
  }
  if (progress) {
    tell(told);
    progress->finish();
  }
}

}  // namespace granuscope
