#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "pipeline/pipeline.h"
#include "support/files.h"

namespace granuscope {

inline RunOptions quiet(const std::filesystem::path& folder, std::vector<Stage> only = {}) {
  RunOptions options;
  options.folder = folder;
  options.threads = 2;
  options.only = std::move(only);
  options.progress = ProgressStyle::silent;
  return options;
}

inline nlohmann::json manifest_of(const std::filesystem::path& folder) {
  return nlohmann::json::parse(read_file(folder / "manifest.json"));
}

}  // namespace granuscope
