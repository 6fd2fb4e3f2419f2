// Loaded into a program beforehand (LD_PRELOAD), this makes of its machine one with the least vector instructions that
// the program knows, and tells so on standard error.
#include <hwy/targets.h>

#include <cstdio>

namespace {

__attribute__((constructor)) void keep_the_least() {
  const auto targets = hwy::SupportedAndGeneratedTargets();
  std::fprintf(stderr, "vectors of %s instead of %s\n", hwy::TargetName(targets.back()),
               hwy::TargetName(targets.front()));
  hwy::DisableTargets(~targets.back());
}

}  // namespace
