#pragma once
#include <optional>
#include <string>

namespace granuscope {

/// The version of a library as it is loaded now, by its name in the manifest ("GSL", "HDF5", "libpng",
/// "FreeType", "OpenSSL", "glibc"). It may be another one than the program was built with. Nothing where the
/// library is not loaded or does not tell.
std::optional<std::string> loaded_version(const std::string& library);

}  // namespace granuscope
