#include "plot/response_in_words.h"

#include <fmt/format.h>

#include "plot/figure_captions.h"

namespace granuscope {

std::string in_words(const ResponseSpec& response) {
  std::string name = name_of(response.estimator);
  if (response.estimator != EstimatorName::multiplexed) return name;
  return fmt::format("{}, ε = {}{}{}", name, caption_number(response.epsilon), response.opposite ? ", opposite" : "",
                     response.sign_run > 1 ? fmt::format(", runs of {}", response.sign_run) : "");
}

}  // namespace granuscope
