#include "support/loaded_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <openssl/crypto.h>

namespace granuscope {
namespace {

// The libraries of higher rooms are asked through the loader, so that no header of theirs is needed here.

template <class Symbol>
Symbol* loaded(const char* name) {
  return reinterpret_cast<Symbol*>(::dlsym(RTLD_DEFAULT, name));
}

std::optional<std::string> hdf5() {
  auto* const ask = loaded<int(unsigned*, unsigned*, unsigned*)>("H5get_libversion");
  unsigned major = 0, minor = 0, release = 0;
  if (ask == nullptr || ask(&major, &minor, &release) < 0) return {};
  return fmt::format("{}.{}.{}", major, minor, release);
}

std::optional<std::string> libpng() {
  auto* const ask = loaded<unsigned()>("png_access_version_number");
  if (ask == nullptr) return {};
  const unsigned version = ask();
  return fmt::format("{}.{}.{}", version / 10000, version / 100 % 100, version % 100);
}

std::optional<std::string> freetype() {
  auto* const open = loaded<int(void**)>("FT_Init_FreeType");
  auto* const ask = loaded<void(void*, int*, int*, int*)>("FT_Library_Version");
  auto* const close = loaded<int(void*)>("FT_Done_FreeType");
  void* library = nullptr;
  if (open == nullptr || ask == nullptr || close == nullptr || open(&library) != 0) return {};
  int major = 0, minor = 0, patch = 0;
  ask(library, &major, &minor, &patch);
  close(library);
  return fmt::format("{}.{}.{}", major, minor, patch);
}

}  // namespace

std::optional<std::string> loaded_version(const std::string& library) {
  if (library == "GSL") {
    const auto* const version = loaded<const char*>("gsl_version");
    if (version != nullptr) return *version;
  } else if (library == "HDF5") {
    return hdf5();
  } else if (library == "libpng") {
    return libpng();
  } else if (library == "FreeType") {
    return freetype();
  } else if (library == "OpenSSL") {
    return OpenSSL_version(OPENSSL_VERSION_STRING);
  } else if (library == "glibc") {
    return gnu_get_libc_version();
  }
  return {};
}

}  // namespace granuscope
