#pragma once
#include <string>

namespace granuscope {

/// The JSON object of a suite with one member more, "measured": by which program and commit, on which processor and
/// day. The machine's name is not in it.
std::string with_measured_with(const std::string& suite_json);

}  // namespace granuscope
