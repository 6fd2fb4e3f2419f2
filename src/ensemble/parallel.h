#pragma once
#include <cstddef>
#include <functional>

namespace granuscope {

/// Calls body(0) .. body(count - 1), each once, on `threads` threads (0: as many as the machine has). Which thread
/// takes which index is left open: bodies must not depend on it. The first exception of a body is passed on after the
/// others have stopped. Within a body one thread does it all.
void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

}  // namespace granuscope
