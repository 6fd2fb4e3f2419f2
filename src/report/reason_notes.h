#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace granuscope {

/// Where an estimate is unknown, the reason as a note below the table. `place`: where among the numbers of that name,
/// as " at μ = 0.1"; those with the same reason share a note, in it those with the same place their place.
void add_reason(nlohmann::ordered_json& notes, const nlohmann::ordered_json& summary, const std::string& pointer,
                const std::string& name, const std::string& place);

/// The name of what a run has scanned; of runs from before there was another, mu.
std::string scanned_in(const nlohmann::ordered_json& summary);
/// Where what was scanned stands in a result: "/results/0/mu".
std::string place_of_scanned(const nlohmann::ordered_json& summary, std::size_t result);
/// "μ = 0.1" of a result.
std::string at_scanned(const nlohmann::ordered_json& summary, std::size_t result);

/// Puts what each note is about into words: "c at μ = 0.1; c and D at μ = 0.6". Each note then has "what", "are" ("is"
/// or "are") and the cell "reason".
void finish_notes(nlohmann::ordered_json& notes);

}  // namespace granuscope
