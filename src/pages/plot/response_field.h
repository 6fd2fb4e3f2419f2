#pragma once
#include <string>

#include "analysis/mean_response.h"
#include "analysis/results.h"
#include "render/scene.h"

namespace granuscope {

/// An ensemble file, of this configuration, whose response can be shown over the plane: with all profiles left in the
/// file, and as many layers as its last recorded one. Throws InputError as open_ensemble(), and where it has none.
MeasuredEnsemble open_response(const std::string& file, const std::string& configuration);

/// The bead of an even or odd row that lies furthest to the left (Lattice::x).
int leftmost_bead(const Lattice& lattice, int row);

/// The mean response at the recorded layers with the fitted rays x = +-(x_0 + c z) and, around each, +-W of
/// W^2 = w_0 + D z.
Field response_field(const MeasuredEnsemble& ensemble, const Transport& transport);

/// x, z, measured and fitted response of every cell.
std::string response_field_csv(const Field& measured, const Transport& transport);

/// Puts the fitted two Gaussians into the right half of each row where the fit has both slopes, so that the measured
/// response stands beside it; rows up to the surface, above those recorded, have the fit alone.
void put_fit_on_the_right(Field& field, const Transport& transport);

}  // namespace granuscope
