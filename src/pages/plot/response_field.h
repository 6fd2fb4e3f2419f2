#pragma once
#include <string>

#include "analysis/mean_response.h"
#include "analysis/results.h"
#include "render/scenes.h"

namespace granuscope {

/// The mean response at the recorded layers with the fitted rays x = +-(x_0 + c z) and, around each, +-W of
/// W^2 = w_0 + D z.
Field response_field(const MeasuredEnsemble& ensemble, const Transport& transport);

/// x, z, measured and fitted response of every cell.
std::string response_field_csv(const Field& measured, const Transport& transport);

/// Puts the fitted two Gaussians into the right half of each row where the fit has both slopes, so that the measured
/// response stands beside it; rows up to the surface, above those recorded, have the fit alone.
void put_fit_on_the_right(Field& field, const Transport& transport);

}  // namespace granuscope
