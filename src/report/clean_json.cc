#include "report/clean_json.h"

#include <nlohmann/json.hpp>

#include "support/clean_text.h"

namespace granuscope {

void clean_strings(nlohmann::ordered_json& document) {
  if (document.is_string()) {
    document = clean_text(document.get_ref<const std::string&>());
  } else if (document.is_structured()) {
    for (auto& element : document) clean_strings(element);
  }
}

}  // namespace granuscope
