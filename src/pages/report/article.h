#pragma once
#include <filesystem>
#include <optional>

#include "report/citation.h"

namespace granuscope {
/// Writes the skeleton of an article that replicates the paper, after ReScience C, into a new folder: article.tex,
/// which pdflatex takes, content.tex, metadata.yaml, bibliography.bib, the numbers of a finished run as macros, and its
/// figures. The title begins with [¬Re] where a tested claim of the paper is not reproduced, else with [Re]. Throws
/// InputError for a folder that is no finished run, has changed since, or has no report, and if `target` has files.
void write_article(const std::filesystem::path& run_folder, const std::filesystem::path& target,
                   const std::optional<Citation>& citation);

}  // namespace granuscope
