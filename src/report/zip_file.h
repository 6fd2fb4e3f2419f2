#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace granuscope {

/// A file in an archive: its name there, and what is in it.
struct ZipEntry {
  std::string name;            ///< with forward slashes
  std::filesystem::path file;  ///< where its bytes are read from, or, if this is empty,
  std::string bytes;           ///< what they are
};

/// Writes an archive with these entries in their order, all with one time of change ("2026-01-31T02:00:00Z", written as
/// it stands, in whatever time zone): the same entries give the same bytes. It appears whole or not at all. Throws
/// EnvironmentError.
void write_zip(const std::filesystem::path& target, const std::vector<ZipEntry>& entries, const std::string& time);

}  // namespace granuscope
