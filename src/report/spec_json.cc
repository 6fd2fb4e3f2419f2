#include "report/spec_json.h"

namespace granuscope {

nlohmann::ordered_json to_json(const ResponseSpec& response) {
  nlohmann::ordered_json json{{"estimator", name_of(response.estimator)}};
  if (response.estimator == EstimatorName::multiplexed) {
    json["epsilon"] = response.epsilon;
    json["opposite"] = response.opposite;
    json["sign_run"] = response.sign_run;
  } else if (response.estimator == EstimatorName::fluctuation) {
    json["reference_lag"] = response.reference_lag;
    json["first_base"] = response.first_base;
    json["base_step"] = response.base_step;
  } else {
    json["overload"] = response.overload;
  }
  return json;
}

}  // namespace granuscope
