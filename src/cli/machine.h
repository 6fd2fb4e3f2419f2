#pragma once

namespace granuscope {

/// Threads that --threads asks for; 0 means all the machine has.
int worker_count(int threads);

/// Throws EnvironmentError if the machine's memory is smaller than `bytes`: the system would only kill the program
/// half way instead of refusing the memory.
void require_memory(double bytes);

/// Memory of one pile under work, per bead: its forces and what a solver keeps beside them, in bytes.
inline constexpr double bytes_per_bead = 100;

}  // namespace granuscope
