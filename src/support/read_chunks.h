#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

namespace granuscope {

/// Hands the bytes of a file to `take`, piece by piece, so that no file need fit in memory. Throws InputError naming
/// the file if it is missing, unreadable or no ordinary file, but a folder, say, or a pipe.
void read_chunks(const std::filesystem::path& source, const std::function<void(std::string_view)>& take);

}  // namespace granuscope
