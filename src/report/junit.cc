#include "report/junit.h"

#include <fmt/format.h>

#include <algorithm>

#include "support/clean_text.h"

namespace granuscope {

namespace {

bool differs(const Claim& claim) { return !claim.expected.empty() && claim.verdict != claim.expected; }

/// Neither reproduced nor refuted: not decided or not tested, as expected.
bool undecided(const Claim& claim) {
  return claim.verdict != "reproduced" && claim.verdict != "not reproduced" && !differs(claim);
}

std::string markup(const std::string& text) { return escape_markup(clean_text(text)); }

}  // namespace

std::string junit_claims(const std::vector<Claim>& claims, const std::string& experiment_name) {
  std::string suite_name = markup(experiment_name);
  std::replace(suite_name.begin(), suite_name.end(), '\n', ' ');
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  const auto skipped = std::count_if(claims.begin(), claims.end(), undecided);
  xml += fmt::format("<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n", suite_name,
                     claims.size(), std::count_if(claims.begin(), claims.end(), differs), skipped);
  for (const Claim& claim : claims) {
    const std::string verdict = markup(claim.verdict), explanation = markup(claim.explanation);
    xml += fmt::format("  <testcase classname=\"claims\" name=\"{}\">", markup(claim.id));
    if (differs(claim)) {
      xml += fmt::format("<failure message=\"the verdict is {}, expected was {}\">{}</failure>", verdict,
                         markup(claim.expected), explanation);
    } else if (undecided(claim)) {
      xml += fmt::format("<skipped message=\"{}\"/>", verdict);
    }
    const std::string remarks = claim.remarks.empty() ? "" : " " + markup(claim.remarks);
    xml += fmt::format("<system-out>{}: {} {}{}</system-out></testcase>\n", verdict, markup(claim.statement),
                       explanation, remarks);
  }
  return xml + "</testsuite>\n";
}

}  // namespace granuscope
