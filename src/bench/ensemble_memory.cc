#include "bench/ensemble_memory.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <exception>
#include <numeric>

#include "ensemble/ensemble_runner.h"
#include "support/error.h"

namespace granuscope {

EnsembleMemory measure_ensemble_memory(int threads) {
  EnsembleSpec spec;
  spec.sampler.mu = 0.1;
  spec.lattice = {500, 200};
  spec.response.samples = 3461;
  spec.layers.resize(static_cast<std::size_t>(Lattice(spec.lattice).usable_layers()));
  std::iota(spec.layers.begin(), spec.layers.end(), 0);
  const pid_t child = ::fork();
  if (child < 0) throw EnvironmentError("no child process can be started; try again");
  if (child == 0) {
    int status = 0;
    try {
      run_ensemble(spec, threads, nullptr);
    } catch (const std::exception&) {
      status = 1;
    }
    ::_exit(status);
  }
  int status = 0;
  rusage used{};
  ::wait4(child, &status, 0, &used);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw EnvironmentError("the ensemble whose memory was to be measured could not be drawn; free some memory");
  }
  return {spec.response.samples, threads, static_cast<double>(used.ru_maxrss) * 1024};
}

}  // namespace granuscope
