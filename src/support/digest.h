#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace granuscope {

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string sha256(std::string_view bytes);
std::string sha256_of_file(const std::filesystem::path& file);

/// 64-bit xxHash (XXH3) as 16 hexadecimal digits: a fast key for caches, not a proof of origin.
std::string cache_key(std::string_view bytes);

}  // namespace granuscope
