#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "packing/packing.h"
#include "packing/packing_file.h"
#include "render/scene.h"

namespace granuscope {
/// Contacts of a packing as bars from centre to centre, over its particles where their radii are known: by N over its
/// mean (scene "forces"), or by |T|/(mu N) ("friction", needs mu). Lengths in mean particle diameters, y up; a window
/// is X0,X1,Y0,Y1. A contact with a wall ends half way. Throws InputError as build_scene() does, where no contact has a
/// place, and where the window has nothing to show.
Scene build_packing_scene(const Packing& packing, double mu, const SceneSpec& spec);

/// A picture of each step of a file, or of each frame. All have one window, and one colour scale over the mean force of
/// all steps; lengths count in mean diameters of the first one. The source must outlive the film; any thread may make
/// any of the pictures.
class PackingFilm {
 public:
  /// Throws InputError as PackingSource::read() and build_packing_scene() do, and for a file of less than two steps.
  PackingFilm(const PackingSource& source, double mu, SceneSpec spec);
  std::size_t frames() const { return steps_.size(); }
  const SceneSpec& spec() const { return spec_; }
  Scene scene(std::size_t frame) const;

 private:
  Packing read(std::size_t frame) const;

  const PackingSource& source_;
  double mu_, diameter_ = 0, force_unit_ = 0, value_max_ = 0;
  SceneSpec spec_;
  std::vector<double> steps_;
};

}  // namespace granuscope
