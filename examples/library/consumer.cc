// What somebody may write who has the library and not the project: draws an ensemble, measures c and D, stores a pile.
#include <cmath>
#include <cstdio>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "model/audit.h"
#include "sampling/sampler.h"
#include "storage/pile_file.h"

int main() {
  using namespace granuscope;
  EnsembleSpec spec;
  spec.lattice.columns = 96;
  spec.lattice.layers = 80;
  spec.sampler.mu = 0.3;
  spec.response.samples = 1024;
  spec.response.estimator = EstimatorName::multiplexed;
  spec.load = Load::point;

  FitSpec fit;
  fit.first_layer = 20;
  fit.last_layer = 56;
  spec.layers = layers_to_record(fit, {});
  spec.record_profiles = true;

  const MeasuredEnsemble ensemble{spec, run_ensemble(spec, 0, nullptr)};
  const Transport transport = measure_transport(ensemble, fit, {}, 0).transport;
  std::printf("c %.4f +- %.4f, D %.4f +- %.4f\n", transport.c.value, transport.c.standard_error, transport.D.value,
              transport.D.standard_error);

  const Lattice lattice(spec.lattice);
  Pile pile(lattice);
  const std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  if (make_sampler(spec.sampler, lattice)->draw(0, load, pile)) return 1;
  write_pile("pile.h5", pile);
  return audit(read_pile("pile.h5")).max_balance_residual < 1e-12 && std::abs(transport.c.value - 0.55) < 0.1 ? 0 : 1;
}
