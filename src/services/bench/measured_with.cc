#include "bench/measured_with.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <exception>
#include <numeric>

#include "ensemble/ensemble_runner.h"
#include "sampling/layer_kernels.h"
#include "support/error.h"
#include "support/provenance.h"

namespace granuscope {
std::string with_measured_with(const std::string& suite_json) {
  const Provenance provenance = collect_provenance();
  const nlohmann::ordered_json measured = {
      {"program", provenance.program_version}, {"commit", provenance.git_commit},
      {"changed", provenance.git_dirty},       {"compiler", provenance.compiler},
      {"processor", provenance.host_cpu},      {"threads", provenance.hardware_threads},
      {"date", current_time().substr(0, 10)}};
  std::string text = suite_json;
  return text.insert(text.find('{') + 1, "\n  \"measured\": " + measured.dump() + ",");
}

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

namespace {

/// Errors of beads that are not repaired grow with depth. Every so many layers the pile starts anew from the load, so
/// that the numbers stay of the size that a solver works with.
constexpr int layers_in_a_row = 16;

}  // namespace

StraightLine::StraightLine(double mu, Lattice lattice)
    : lattice_(lattice),
      cone_(mu),
      uniforms_(static_cast<std::size_t>(lattice.columns()) + uniform_padding),
      half_load_(static_cast<std::size_t>(lattice.columns()), 0.5),
      no_force_(static_cast<std::size_t>(lattice.columns())),
      H_(static_cast<std::size_t>(lattice.columns())),
      slack_(static_cast<std::size_t>(lattice.columns())) {}

void StraightLine::fill(std::uint64_t seed, std::uint64_t sample, Pile& pile) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    fill_first_uniforms(seed, static_cast<std::uint32_t>(sample), layer, uniforms_.data(), columns);
    const std::size_t here = lattice_.index(layer, 0);
    const auto row = [&](std::size_t from) {
      return LowerRow{&pile.V_R[here + from], &pile.V_L[here + from], &H_[from],
                      &pile.H_R[here + from], &pile.H_L[here + from], &slack_[from]};
    };
    if (layer % layers_in_a_row == 0) {
      const double* const half = half_load_.data();
      draw_beads(cone_, {half, half, no_force_.data(), no_force_.data()}, uniforms_.data(), columns, row(0));
      continue;
    }
    const std::size_t up = lattice_.index(layer - 1, 0);
    const auto above = [&](std::size_t upper_left, std::size_t upper_right) {
      return UpperRow{&pile.V_R[up + upper_left], &pile.V_L[up + upper_right], &pile.H_R[up + upper_left],
                      &pile.H_L[up + upper_right]};
    };
    // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
    const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
    draw_beads(cone_, above(0, 1), &uniforms_[first], columns - 1, row(first));
    draw_beads(cone_, above(columns - 1, 0), &uniforms_[seam], 1, row(seam));
  }
}

}  // namespace granuscope
