#include "storage/hdf5_handle.h"

#include <hdf5.h>

#include <type_traits>

namespace granuscope {
namespace {

static_assert(std::is_same_v<hid_t, Hdf5Id>, "Hdf5Id must be what the library uses");
static_assert(std::is_same_v<herr_t, int>, "Hdf5Handle::Close must have the type of the library's close functions");

std::mutex library_mutex;

}  // namespace

Hdf5Session::Hdf5Session() : lock_(library_mutex) { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

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
