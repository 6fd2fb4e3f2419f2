#pragma once
#include <array>
#include <cstdint>
#include <filesystem>

#include "render/scene.h"

namespace granuscope {

/// More elements than these make a file that viewers open slowly, if at all, and that says no more than pixels do.
inline constexpr std::uint64_t most_vector_elements = 20000;

/// Writes a scene as SVG or PDF, by the ending of the name, whole or not at all: the layout of the pixel picture, in
/// which a pixel is a unit; text as outlines, so that no font is needed. The same scene gives the same bytes. Returns
/// the size in units. Throws InputError if the scene has too many elements, EnvironmentError if the file cannot be
/// written.
std::array<int, 2> write_vector(const std::filesystem::path& path, const Scene& scene, const SceneSpec& spec,
                                const ImageMetadata& metadata);

}  // namespace granuscope
