#pragma once
#include <string>

namespace granuscope {

/// "12.3 MB", "25.3 GB", "4.61e+08 TB": decimal prefixes, three digits, never less than a megabyte.
std::string describe_bytes(double bytes);

}  // namespace granuscope
