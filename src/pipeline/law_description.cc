#include "pipeline/law_description.h"

#include <sstream>

#include "support/template_file.h"

namespace granuscope {

std::vector<std::string> law_description(const std::string& law) {
  std::istringstream lines{std::string(template_file("law/" + law + ".txt"))};
  std::vector<std::string> sentences;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) sentences.push_back(line);
  }
  return sentences;
}

}  // namespace granuscope
