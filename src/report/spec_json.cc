#include "report/spec_json.h"

namespace granuscope {

nlohmann::ordered_json to_json(const ResponseSpec& response) {
  nlohmann::ordered_json json{{"estimator", name_of(response.estimator)}};
  if (response.estimator == EstimatorName::multiplexed) {
    json["epsilon"] = response.epsilon;
    json["opposite"] = response.opposite;
    json["sign_run"] = response.sign_run;
  } else {
    json["overload"] = response.overload;
  }
  return json;
}

}  // namespace granuscope
