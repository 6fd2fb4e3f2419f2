#include "studies/registry.h"

#include "studies/chain_share.h"
#include "studies/counted_work.h"
#include "studies/deep_response.h"
#include "studies/dilution/study.h"
#include "studies/error_against_time.h"
#include "studies/law_comparison/study.h"
#include "studies/mode_coupling/study.h"
#include "studies/model_classes/study.h"
#include "studies/nonlinearity/study.h"
#include "studies/numerical_stability.h"
#include "studies/redrawn_beads.h"
#include "studies/rejection_thrust.h"
#include "studies/small_friction.h"

namespace granuscope {

Studies::Studies() {
  all_.push_back(redrawn_beads_study());
  all_.push_back(counted_work_study());
  all_.push_back(small_friction_study());
  all_.push_back(deep_response_study());
  all_.push_back(mode_coupling_study());
  all_.push_back(chain_share_study());
  all_.push_back(numerical_stability_study());
  all_.push_back(error_against_time_study());
  all_.push_back(nonlinearity_study());
  all_.push_back(law_comparison_study());
  all_.push_back(rejection_thrust_study());
  all_.push_back(models_study());
  all_.push_back(dilution_study());
}

Studies::Studies(const Studies& other) {
  for (const auto& study : other.all_) all_.push_back(study->clone());
}

Studies& Studies::operator=(const Studies& other) {
  if (this != &other) *this = Studies(other);
  return *this;
}

nlohmann::ordered_json enumerated(const std::vector<std::string>& pointers) {
  nlohmann::ordered_json places = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < pointers.size(); ++i) {
    const std::size_t left = pointers.size() - 1 - i;
    places.push_back({{"key", pointers[i]}, {"joint", left > 1 ? ", " : left == 1 ? " and " : ""}});
  }
  return places;
}

std::vector<StudyEnsemble> Studies::ensembles(const MainLine& main) const {
  std::vector<StudyEnsemble> ensembles;
  for (const auto& study : all_) {
    if (!study->asked()) continue;
    for (StudyEnsemble& one : study->ensembles(main)) ensembles.push_back(std::move(one));
  }
  return ensembles;
}

}  // namespace granuscope
