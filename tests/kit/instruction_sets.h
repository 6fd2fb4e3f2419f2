#pragma once
#include <hwy/targets.h>

#include <catch2/catch.hpp>

namespace granuscope {

/// Calls `check` once for every instruction set this machine and the build have, with that one dispatched to.
template <typename Check>
void for_each_instruction_set(Check check) {
  int tried = 0;
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    INFO("instruction set " << hwy::TargetName(target));
    check();
    ++tried;
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  CHECK(tried >= 1);
}

}  // namespace granuscope
