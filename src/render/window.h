#pragma once
#include "model/pile_view.h"
#include "render/scene.h"

namespace granuscope {

/// The part of the plane that a specification asks for: whole beads, from the top of the first layer to the bottom of
/// the last one. Throws InputError if the window is empty, holds no layer or leaves the pile.
Extent extent_of(const Lattice& lattice, const SceneSpec& spec);

/// The layers and beads whose contacts may reach into the window, and which of their forces the scene is about; all of
/// them if nothing is to be skipped.
PileRange range_needed(const Lattice& lattice, const SceneSpec& spec);

}  // namespace granuscope
