#pragma once
#include <string>
#include <vector>

#include "sampling/sampler_spec.h"

namespace granuscope {

/// The choices that shape a law, one sentence each, as the report states them (templates/law/<name>.txt, one a line).
std::vector<std::string> law_description(const std::string& law);

}  // namespace granuscope
