#pragma once
#include <string>

#include "packing/packing.h"
#include "render/scene.h"

namespace granuscope {
/// Contacts of a packing as bars from centre to centre, over its particles where their radii are known: by N over its
/// mean (scene "forces"), or by |T|/(mu N) ("friction", needs mu). Lengths in mean particle diameters, y up; a window
/// is X0,X1,Y0,Y1. A contact with a wall ends half way. Throws InputError as build_scene() does, and where no contact
/// has a place.
Scene build_packing_scene(const Packing& packing, double mu, const SceneSpec& spec);

}  // namespace granuscope
