#include "report/junit.h"

#include <fmt/format.h>

#include <algorithm>

#include "support/clean_text.h"

namespace granuscope {

namespace {

bool differs(const Claim& claim) { return !claim.expected.empty() && claim.verdict != claim.expected; }

std::string markup(const std::string& text) { return escape_markup(clean_text(text)); }

}  // namespace

std::string junit_claims(const std::vector<Claim>& claims, const std::string& experiment_name) {
  std::string suite_name = markup(experiment_name);
  std::replace(suite_name.begin(), suite_name.end(), '\n', ' ');
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  xml += fmt::format("<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"0\">\n", suite_name,
                     claims.size(), std::count_if(claims.begin(), claims.end(), differs));
  for (const Claim& claim : claims) {
    xml += fmt::format("  <testcase classname=\"claims\" name=\"{}\">{}", markup(claim.id), markup(claim.verdict));
    if (differs(claim)) {
      xml += fmt::format("<failure message=\"the verdict is {}, expected was {}\">{}</failure>", markup(claim.verdict),
                         markup(claim.expected), markup(claim.explanation));
    }
    const std::string remarks = claim.remarks.empty() ? "" : " " + markup(claim.remarks);
    xml += fmt::format("<system-out>{} {}{}</system-out></testcase>\n", markup(claim.statement),
                       markup(claim.explanation), remarks);
  }
  return xml + "</testsuite>\n";
}

}  // namespace granuscope
