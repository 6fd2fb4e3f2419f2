#pragma once
#include <vector>

#include "analysis/results.h"
#include "experiment/experiment.h"
#include "plot/figure.h"

namespace granuscope {

/// The plots of the main line that the experiment asks for, in reading order. The analysis must outlive them.
std::vector<FigurePlot> main_figures(const Experiment& experiment, const Analysis& analysis);

}  // namespace granuscope
