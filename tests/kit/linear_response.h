#pragma once

namespace granuscope::test {

/// c and D of the linear response, each with one standard error.
struct LinearResponse {
  double mu;
  double c, c_error;
  double D, D_error;
};

/// Numbers on record, as an independent implementation that is not in the repository printed them: law granusolve,
/// multiplexed with epsilon 0.25, 500 x 200 beads, 1500 samples, slopes over layers 58 to 179. Its seed is not known.
inline constexpr LinearResponse linear_response[] = {
    {.mu = 0.1, .c = 0.5749, .c_error = 0.0001, .D = 0.0061, .D_error = 0.0001},
    {.mu = 0.2, .c = 0.5678, .c_error = 0.0001, .D = 0.0297, .D_error = 0.0006},
    {.mu = 0.3, .c = 0.5580, .c_error = 0.0002, .D = 0.0818, .D_error = 0.0014}};

}  // namespace granuscope::test
