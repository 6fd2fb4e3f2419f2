#include "bench/measured_with.h"

#include <nlohmann/json.hpp>

#include "support/provenance.h"

namespace granuscope {

std::string with_measured_with(const std::string& suite_json) {
  const Provenance provenance = collect_provenance();
  const nlohmann::ordered_json measured = {
      {"program", provenance.program_version}, {"commit", provenance.git_commit},
      {"changed", provenance.git_dirty},       {"compiler", provenance.compiler},
      {"processor", provenance.host_cpu},      {"threads", provenance.hardware_threads},
      {"date", current_time().substr(0, 10)}};
  std::string text = suite_json;
  return text.insert(text.find('{') + 1, "\n  \"measured\": " + measured.dump() + ",");
}

}  // namespace granuscope
