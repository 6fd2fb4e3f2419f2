#pragma once
#include <string>

namespace granuscope {

/// The system's words for an errno value and, where there is one, what the user can do about it:
/// "No space left on device. Free some space there or choose another folder."
std::string system_reason(int error_number);

}  // namespace granuscope
