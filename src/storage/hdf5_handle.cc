#include "storage/hdf5_handle.h"

#include <hdf5.h>

#include <stdexcept>
#include <type_traits>

namespace granuscope {
namespace {

static_assert(std::is_same_v<hid_t, Hdf5Id>, "Hdf5Id must be what the library uses");
static_assert(std::is_same_v<herr_t, int>, "Hdf5Handle::Close must have the type of the library's close functions");

std::mutex library_mutex;

/// A file may ask for a filter that the library does not have, and HDF5_PLUGIN_PATH or a folder that others can write
/// to would give it: code that runs because a file was read. Ours need none.
void load_no_plugins() {
  if (H5PLset_loading_state(0) < 0) throw std::runtime_error("HDF5 would load plugins, and cannot be told not to");
}

}  // namespace

Hdf5Session::Hdf5Session() : lock_(library_mutex) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  static const bool once = (load_no_plugins(), true);
  (void)once;
}

std::string hdf5_reason() {
  std::string reason;
  const auto take_first = [](unsigned /*number*/, const H5E_error2_t* error, void* text) -> herr_t {
    if (error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
    return 1;  // the walk begins at the place that failed: one is enough
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &reason);
  return reason;
}

}  // namespace granuscope
