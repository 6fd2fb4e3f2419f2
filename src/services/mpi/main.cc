// granuscope-mpi: the program whose ensembles are drawn by all ranks of an MPI job.
#include <mpi.h>
#include <unistd.h>

#include <exception>
#include <iostream>

#include "cli/command_line.h"
#include "mpi/mpi_crew.h"
#include "support/error.h"
#include "support/progress.h"

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
