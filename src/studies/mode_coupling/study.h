#pragma once
#include <memory>
#include <vector>

#include "studies/mode_coupling/fields.h"
#include "studies/study.h"

namespace granuscope {

/// Why the peaks spread faster than diffusion: they are sound, and torque, which stays where it is and spreads there,
/// is conserved, too, and lowers the thrust. One closed form follows (sound_form.h), whose B comes from piles under
/// loads that lean or act beside the centres and from the fluctuations of single layers.
std::unique_ptr<Study> mode_coupling_study();

/// What the sentences of page 1 need beside the results; null where nothing is predicted. The prediction holds at a
/// friction coefficient if its strength is 1 within the claim's tolerance and three errors, and if it describes W^2
/// better than one D: errors alone do not make it hold.
nlohmann::ordered_json coupling_page_1(const std::vector<CoupledSpreading>& measured);

}  // namespace granuscope
