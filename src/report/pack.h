#pragma once
#include <filesystem>
#include <optional>

#include "report/citation.h"

namespace granuscope {

/// How a finished run is packed.
struct PackOptions {
  std::optional<Citation> citation;  ///< whose run it is, and under which licence; none: nobody is named
  bool with_ensembles = false;       ///< all that was drawn, too, which is most of the bytes
};

/// Writes a finished run as one archive (zip) with ro-crate-metadata.json, a research object after RO-Crate 1.1: what
/// each file is, with its SHA-256, and which program, commit and command made them from which experiment. The same run
/// gives the same bytes. Returns how many files are in it. Throws InputError for a folder whose last run did not come
/// to its report, or whose files are not those that it left; EnvironmentError if the archive cannot be written.
std::size_t pack_run(const std::filesystem::path& run_folder, const std::filesystem::path& archive,
                     const PackOptions& options);

}  // namespace granuscope
