#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "packing/number_table.h"

namespace granuscope {
/// A name of a column without quotes, its unit ("x: m", "x [m]", "x (m)") and capitals.
std::string plain_name(std::string_view cell);

/// Whether a file is one of VTK: XML (vtu, vtp) or legacy (vtk).
bool is_vtk(std::string_view text);

/// The lines of two points of an unstructured grid or of polygonal data (x1, y1, x2, y2, point1, point2, and the arrays
/// of cells, of vectors name_x and name_y), or its points (x, y, point, and their arrays; without those of radius 0,
/// which are ends of lines). Points at one place are one. All encodings of VTK are read, but no file of several pieces.
/// Throws InputError for a file that is cut or has no such lines.
NumberTable read_vtk_table(const std::filesystem::path& file, std::string_view text, TableOf part);

}  // namespace granuscope
