#pragma once
#include <string>

#include "ensemble/response_spec.h"

namespace granuscope {

/// "multiplexed, ε = 0.25, opposite, runs of 2"; of another estimator its name.
std::string in_words(const ResponseSpec& response);

}  // namespace granuscope
