#pragma once

namespace granuscope {

/// Processor time of this thread so far, in seconds: what a piece of work took however busy the machine is.
double processor_seconds();

}  // namespace granuscope
