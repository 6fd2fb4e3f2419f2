#pragma once
// What the figures of studies still include until they stand in a room of their own.
#include "plot/axes.h"
#include "plot/point_selection.h"
