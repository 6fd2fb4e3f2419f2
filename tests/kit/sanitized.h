#pragma once

namespace granuscope::test {

/// Whether address and undefined-behaviour checks are built in. They cost a factor of ten.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace granuscope::test
