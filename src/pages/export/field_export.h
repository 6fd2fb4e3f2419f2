#pragma once
#include <filesystem>
#include <string>

#include "analysis/mean_response.h"
#include "export/pile_export.h"

namespace granuscope {
enum class FieldFormat { vti, csv };

/// The mean response P(x, z) of an ensemble that has one (open_response) with its standard errors. As image data of VTK
/// each bead is a cell one bead diameter wide, in two halves since every other row lies half a bead further right, and
/// as high as the rows are apart; y points up, and layers that were not recorded are not numbers. Throws as
/// export_pile(), InputError where an image of this size cannot be.
void export_field(const MeasuredEnsemble& ensemble, FieldFormat format, const std::filesystem::path& file,
                  const std::string& origin, const Accept& accept);

}  // namespace granuscope
