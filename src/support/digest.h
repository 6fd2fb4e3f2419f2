#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace granuscope {

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string sha256(std::string_view bytes);
std::string sha256_of_file(const std::filesystem::path& file);

/// The first 16 of these digits: a key for caches.
std::string cache_key(std::string_view bytes);

}  // namespace granuscope
