#pragma once
#include <filesystem>
#include <string>

namespace granuscope {

/// Name for work in progress beside a file called `name`: hidden, with its last letters (programs look at the suffix),
/// short enough for any file system, and telling which process on which machine made it. Different at each call.
std::string scratch_name(const std::string& name);

/// Removes from a folder what such processes left there when they were killed, files and folders, and returns how many
/// there were. What belongs to a process still running, or to another machine or container, stays. A folder that is not
/// there, or cannot be changed, is left alone.
int remove_leftovers(const std::filesystem::path& folder);

/// The same, but only what was to become `file`.
int remove_leftovers_of(const std::filesystem::path& file);

}  // namespace granuscope
