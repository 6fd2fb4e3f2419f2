#pragma once
#include <filesystem>
#include <string>

#include "model/pile.h"

namespace granuscope {
/// A pile for ParaView: PileFormat::vtu of export_pile().
void write_vtu(PileLayers& pile, const std::filesystem::path& file, const std::string& comment);
}  // namespace granuscope
