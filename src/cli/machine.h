#pragma once
#include <filesystem>

namespace granuscope {

/// Threads that --threads asks for; 0 means all the machine has.
int worker_count(int threads);

/// Memory that this process may use, in bytes: the machine's, or less if its container (control group) is given less.
/// `root` is where the system's folders are looked for (tests).
double usable_memory(const std::filesystem::path& root = "/");

/// Throws EnvironmentError if the usable memory is smaller than `bytes`: the system would only kill the program
/// half way instead of refusing the memory.
void require_memory(double bytes);

/// Memory of one pile under work, per bead: its forces and what a solver keeps beside them, in bytes.
inline constexpr double bytes_per_bead = 100;

}  // namespace granuscope
