#pragma once

namespace granuscope {

/// Throws EnvironmentError if the machine's memory is smaller than `bytes`: the system would only kill the program
/// half way instead of refusing the memory.
void require_memory(double bytes);

/// Memory of one pile under work, per bead: its forces and what a solver keeps beside them, in bytes.
inline constexpr double bytes_per_bead = 100;

}  // namespace granuscope
