#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "sampling/scan_parameter.h"

namespace granuscope {

/// The script with its texts in another language: in every quoted text that is no file name, the phrases of a catalogue
/// (templates/plot/labels.txt has its form) and the decimal point are replaced; a longer phrase comes before one that
/// it holds. Throws InputError for a line of the catalogue that is none.
std::string in_language(const std::string& script, std::string_view catalogue);

/// Any text with the phrases of a catalogue replaced, as whole words; its decimal points stay.
std::string in_terms(const std::string& text, std::string_view catalogue);

/// The catalogue by which texts about friction speak of what else an experiment varies; empty for friction itself.
std::string terms_of(const ScanParameter& parameter);

/// The quoted texts of a script that are neither file names nor formats, as they stand.
std::vector<std::string> texts_of_script(std::string_view script);

/// The catalogue of a language that is built in: "en" (nothing changes), "fr", "de". Throws InputError for another.
std::string_view catalogue_of(const std::string& language);

}  // namespace granuscope
