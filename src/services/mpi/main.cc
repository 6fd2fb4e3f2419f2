// granuscope-mpi: the program whose ensembles are drawn by all ranks of an MPI job.
#include <fmt/format.h>
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <iostream>
#include <iterator>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cli/command_line.h"
#include "experiment/experiment_file.h"
#include "pipeline/block_files.h"
#include "pipeline/sample_stage.h"
#include "pipeline/shards.h"
#include "storage/block_sums.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"
#include "support/provenance.h"

namespace granuscope {
/// The processes of an MPI program. Nothing here blocks inside the library: a rank that waits looks now and then
/// whether it is asked to stop, and then throws Interrupted, so that the end of one rank is not the hanging of the
/// others.
class Ranks {
 public:
  /// Between MPI_Init and MPI_Finalize, on the thread that called the former, like all that follows.
  Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }
  /// Ranks on this machine.
  int on_this_machine() const { return local_; }

  /// The bytes of rank `from`, on every rank.
  std::string broadcast(std::string bytes, int from = 0);
  /// The bytes of every rank, in order, on rank 0; nothing on others.
  std::vector<std::string> gather(std::string bytes);
  int largest(int value);
  int smallest(int value);
  /// Returns when all ranks have come here.
  void wait_for_all();

  // Two shared counters, kept by rank 0.
  enum Counter { taken, finished };
  /// Sets both to 0; all ranks have done so when it returns.
  void reset_counters();
  /// Adds to a counter, and returns what it was before.
  std::int64_t add(Counter counter, std::int64_t value);
  /// Lets the library answer others while this rank waits for something else.
  void attend();

  /// Gives up the counters before MPI_Finalize.
  void close();

 private:
  void wait(MPI_Request request);

  int rank_ = 0, size_ = 1, local_ = 1;
  MPI_Win window_ = MPI_WIN_NULL;
  std::int64_t* counters_ = nullptr;
};

/// The ranks of an MPI program as a crew. Rank 0 runs the command and calls draw(); the others follow it. All take
/// blocks from one shared counter, the dearest first, so that slow machines take fewer. Each writes the blocks it has
/// drawn into the run's folder, which all must see, and puts them at their places in the ensemble (block_files.h);
/// nothing but the numbers of blocks and notes about them goes through the network.
class MpiCrew : public Crew {
 public:
  explicit MpiCrew(Ranks& ranks) : ranks_(ranks) {}

  void draw(const Experiment& experiment, const RunOptions& options,
            const std::vector<PlannedEnsemble>& ensembles) override;

  /// Rank 0: the others end with this status.
  void end(int code);
  /// The other ranks: draw what rank 0 asks for until it ends; returns its status.
  int follow();

 private:
  /// `finish` is handed on rank 0 what each rank tells of the blocks that it has put at their places.
  void work(const std::string& task, ProgressStyle style,
            const std::function<void(const std::vector<std::string>&)>& finish);

  Ranks& ranks_;
};

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

  static auto fields(auto& task) {
    return std::tie(task.experiment, task.folder, task.threads, task.sizes, task.atoms);
  }
};

/// Threads of this rank: those asked for, or its share of the processors. A rank that is bound to some has these to
/// itself; without, all ranks of a machine share it.
int threads_of(const Ranks& ranks, int asked) {
  if (asked > 0) return asked;
  Processors mine = find_processors();
  const int ranks_here = ranks.on_this_machine();
  if (mine.task == 0 && mine.bound >= mine.machine) mine.bound = mine.machine / ranks_here;
  mine.quota /= ranks_here;
  return mine.usable();
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

/// Other machines may see a file later than the one that made it.
void wait_for(const fs::path& file) {
  const auto deadline = std::chrono::steady_clock::now() + folder_delay;
  while (!path_exists(file)) {
    throw_if_interrupted();
    if (std::chrono::steady_clock::now() > deadline) {
      throw EnvironmentError(
          "'{}' was made by rank 0 and is not seen by another rank, so that the ranks do not share the folder; choose "
          "an --out that all machines see",
          file.string());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

/// The places of blocks depend on it.
std::string key_of(const PlannedEnsemble& planned) {
  return cache_key(configuration_text(planned.spec) + planned.notes);
}

/// The blocks that a rank has put at their places, by ensemble.
class Placed {
 public:
  Placed(const std::vector<PlannedEnsemble>& ensembles, const fs::path& folder) : ensembles_(ensembles) {
    notes_.resize(ensembles.size());
    for (const PlannedEnsemble& planned : ensembles) {
      const PlacedBlocks placed(planned, folder);
      wait_for(placed.file());
      files_.push_back(placed.open());
    }
  }

  /// Any number of threads may do so.
  void put(const Atom& atom, const EnsembleRecord& block) {
    files_[atom.ensemble]->put(static_cast<std::size_t>(atom.block), block.sums);
    const std::lock_guard lock(mutex_);
    notes_[atom.ensemble].push_back(note_of(block));
  }

  /// The files of single blocks of ensembles that are whole: each rank removes its own, since all of them are many.
  void remove_files_of_whole(const fs::path& folder) const {
    for (std::size_t i = 0; i < ensembles_.size(); ++i) {
      if (path_exists(PlacedBlocks(ensembles_[i], folder).file())) continue;
      const BlockFiles files(ensembles_[i], folder);
      for (const BlockNote& note : notes_[i]) remove_if_there(files.file(note.block));
    }
  }

  std::string to_bytes() const {
    ByteWriter writer;
    for (std::size_t i = 0; i < ensembles_.size(); ++i) writer.put(std::pair(key_of(ensembles_[i]), notes_[i]));
    return writer.take();
  }

 private:
  const std::vector<PlannedEnsemble>& ensembles_;
  std::vector<std::unique_ptr<SharedEnsemble>> files_;
  std::mutex mutex_;
  std::vector<std::vector<BlockNote>> notes_;
};

/// The notes of all ranks, by ensemble and block.
std::vector<std::vector<BlockNote>> notes_of_all(const std::vector<PlannedEnsemble>& ensembles,
                                                 const std::vector<std::string>& ranks) {
  std::vector<std::vector<BlockNote>> notes(ensembles.size());
  for (const std::string& bytes : ranks) {
    ByteReader reader(bytes);
    for (std::size_t i = 0; i < ensembles.size(); ++i) {
      auto [key, more] = reader.get<std::pair<std::string, std::vector<BlockNote>>>();
      if (key != key_of(ensembles[i])) throw std::logic_error("the ranks do not mean the same ensemble");
      std::ranges::move(more, std::back_inserter(notes[i]));
    }
  }
  for (auto& of_one : notes) {
    std::ranges::sort(of_one, [](const BlockNote& one, const BlockNote& other) { return one.block < other.block; });
  }
  return notes;
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
    if (planned.reusable || PlacedBlocks(planned, options.folder).complete()) continue;
    const auto same = std::ranges::find_if(all, [&](const auto& one) { return one.file == planned.file; });
    task.sizes.push_back(
        {static_cast<std::uint64_t>(same - all.begin()), planned.spec.response.samples, planned.groups_before});
    wanted.push_back(planned);
  }
  task.atoms = atoms_of(wanted);
  if (task.atoms.empty()) return;
  for (const PlannedEnsemble& planned : wanted) PlacedBlocks(planned, options.folder).begin();
  work(ranks_.broadcast(to_bytes(std::pair(Command::draw, task))), options.progress,
       [&](const std::vector<std::string>& told) {
         const auto notes = notes_of_all(wanted, told);
         for (std::size_t i = 0; i < wanted.size(); ++i) {
           const PlacedBlocks placed(wanted[i], options.folder);
           placed.keep_notes(notes[i]);
           placed.finish();
         }
       });
  // By now each rank has removed the files of the blocks that it has put there.
  for (const PlannedEnsemble& planned : wanted) {
    if (!path_exists(PlacedBlocks(planned, options.folder).file())) BlockFiles(planned, options.folder).remove();
  }
}

void MpiCrew::end(int code) { ranks_.broadcast(to_bytes(std::pair(Command::end, code))); }

int MpiCrew::follow() {
  for (;;) {
    const std::string received = ranks_.broadcast({});
    ByteReader reader(received);
    if (reader.get<Command>() == Command::end) return reader.get<int>();
    try {
      work(received, ProgressStyle::silent, [](const std::vector<std::string>&) {});
    } catch (const Interrupted&) {
      throw;
    } catch (const Error&) {  // NOLINT(bugprone-empty-catch): all ranks know of it, and rank 0 tells it
    }
  }
}

void MpiCrew::work(const std::string& received, ProgressStyle style,
                   const std::function<void(const std::vector<std::string>&)>& finish) {
  using namespace std::chrono_literals;
  const auto task = from_bytes<std::pair<Command, Task>>(received).second;
  const std::vector<PlannedEnsemble> known =
      all_ensembles(parse_experiment(task.experiment, "the experiment of rank 0"), {});
  std::vector<PlannedEnsemble> ensembles;
  for (const Size& size : task.sizes) {
    PlannedEnsemble& one = ensembles.emplace_back(known.at(size.ensemble));
    one.spec.response.samples = size.samples;
    one.groups_before = size.groups_before;
  }
  const fs::path folder = task.folder;
  const int threads = threads_of(ranks_, task.threads);
  ranks_.reset_counters();

  std::optional<Placed> placed;
  Hand hand(task.atoms);
  std::exception_ptr thrown;
  std::atomic<bool> drawn{false};
  const auto blocks = static_cast<std::int64_t>(task.atoms.size());
  std::optional<Progress> progress;
  if (ranks_.rank() == 0) {
    progress.emplace(fmt::format("drawing on {}, blocks", how_many(ranks_.size(), "rank")), task.atoms.size(), style);
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
        placed.emplace(ensembles, folder);
        draw_atoms(
            ensembles, folder, threads, style, nullptr, {}, [&] { return hand.next(); },
            [&](const Atom& atom, const EnsembleRecord& block) { placed->put(atom, block); });
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
  // What goes wrong on one rank is thrown on all.
  const auto throw_together = [this](const Failure& failure) {
    const int code = ranks_.largest(failure.code);
    if (code == 0) return;
    const int whose = ranks_.smallest(failure.code == code ? ranks_.rank() : ranks_.size());
    rethrow({code, fmt::format("{}", ranks_.broadcast(failure.message, whose))});
  };
  const Failure mine = describe(thrown);
  if (mine.code != 0) {
    ranks_.add(Ranks::taken, no_more);
  } else {
    tell(hand.given());
  }
  throw_together(mine);
  const std::vector<std::string> notes = ranks_.gather(placed->to_bytes());
  Failure finishing;
  try {
    finish(notes);
  } catch (...) {
    finishing = describe(std::current_exception());
  }
  throw_together(finishing);
  placed->remove_files_of_whole(folder);
  ranks_.wait_for_all();
  if (progress) {
    tell(told);
    progress->finish();
  }
}

Ranks::Ranks() {
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &local_);
  MPI_Comm_free(&machine);
  MPI_Win_allocate(rank_ == 0 ? 2 * static_cast<MPI_Aint>(sizeof(std::int64_t)) : 0, sizeof(std::int64_t),
                   MPI_INFO_NULL, MPI_COMM_WORLD, static_cast<void*>(&counters_), &window_);
  MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
}

void Ranks::close() {
  MPI_Win_unlock_all(window_);
  MPI_Win_free(&window_);
}

void Ranks::wait(MPI_Request request) {
  using namespace std::chrono_literals;
  auto pause = 20us;
  for (;;) {
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done != 0) return;
    throw_if_interrupted();
    std::this_thread::sleep_for(pause);
    pause = std::min<std::chrono::microseconds>(2 * pause, 2ms);
  }
}

// NOLINTBEGIN(clang-analyzer-optin.mpi.MPI-Checker): each request is waited for in wait(), which it cannot see.

std::string Ranks::broadcast(std::string bytes, int from) {
  std::uint64_t size = bytes.size();
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&size, 1, MPI_UINT64_T, from, MPI_COMM_WORLD, &request);
  wait(request);
  bytes.resize(size);
  MPI_Ibcast(bytes.data(), static_cast<int>(size), MPI_BYTE, from, MPI_COMM_WORLD, &request);
  wait(request);
  return bytes;
}

std::vector<std::string> Ranks::gather(std::string bytes) {
  const auto size = static_cast<int>(bytes.size());
  const auto ranks = static_cast<std::size_t>(rank_ == 0 ? size_ : 0);
  std::vector<int> sizes(ranks), places(ranks);
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Igather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
  wait(request);
  std::exclusive_scan(sizes.begin(), sizes.end(), places.begin(), 0);
  std::string all(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}), '\0');
  MPI_Igatherv(bytes.data(), size, MPI_BYTE, all.data(), sizes.data(), places.data(), MPI_BYTE, 0, MPI_COMM_WORLD,
               &request);
  wait(request);
  std::vector<std::string> each;
  for (std::size_t i = 0; i < ranks; ++i) {
    each.push_back(all.substr(static_cast<std::size_t>(places[i]), static_cast<std::size_t>(sizes[i])));
  }
  return each;
}

int Ranks::largest(int value) {
  int result = value;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(&value, &result, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD, &request);
  wait(request);
  return result;
}

int Ranks::smallest(int value) { return -largest(-value); }

void Ranks::reset_counters() {
  for (const Counter counter : {taken, finished}) {
    if (rank_ != 0) continue;
    const std::int64_t before = add(counter, 0);
    add(counter, -before);
  }
  wait_for_all();
}

void Ranks::wait_for_all() {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  wait(request);
}

std::int64_t Ranks::add(Counter counter, std::int64_t value) {
  std::int64_t before = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  // Fetch and add; unlike MPI_Fetch_and_op this can be waited for without blocking.
  MPI_Rget_accumulate(&value, 1, MPI_INT64_T, &before, 1, MPI_INT64_T, 0, counter, 1, MPI_INT64_T, MPI_SUM, window_,
                      &request);
  wait(request);
  return before;
}

// NOLINTEND(clang-analyzer-optin.mpi.MPI-Checker)

void Ranks::attend() {
  int message = 0;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &message, MPI_STATUS_IGNORE);
}

}  // namespace granuscope

namespace {

using namespace granuscope;

constexpr int interrupted = static_cast<int>(ExitCode::interrupted);

/// After an interruption other ranks may be gone, and the library would wait for them for ever.
[[noreturn]] void leave_at_once() {
  std::cout.flush();
  ::_exit(interrupted);
}

int run(int argc, char** argv, Ranks& ranks) {
  MpiCrew crew(ranks);
  try {
    if (ranks.rank() != 0) {
      install_interruption_handlers();
      return crew.follow();
    }
    const int code = run_command_line(argc, argv, std::cout, std::cerr, &crew);
    if (code == interrupted) leave_at_once();
    crew.end(code);
    return code;
  } catch (const Interrupted&) {
    leave_at_once();
  } catch (const std::exception& error) {
    std::cerr << "granuscope-mpi: rank " << ranks.rank() << ": " << error.what() << '\n';
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(ExitCode::environment));
  }
  return interrupted;
}

}  // namespace

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  int code = interrupted;
  {
    Ranks ranks;
    code = run(argc, argv, ranks);
    ranks.close();
  }
  MPI_Finalize();
  return code;
}
