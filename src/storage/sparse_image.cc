#include "storage/sparse_image.h"

#include <hdf5.h>

#include <algorithm>
#include <memory>

namespace granuscope {
namespace {

constexpr std::size_t page_bytes = std::size_t{1} << 16;

/// An open file as the library sees it: its own part first.
struct OpenImage {
  H5FD_t base = {};
  SparseImage* image = nullptr;
  haddr_t end_of_allocation = 0;
};

OpenImage* from(H5FD_t* file) { return reinterpret_cast<OpenImage*>(file); }
const OpenImage* from(const H5FD_t* file) { return reinterpret_cast<const OpenImage*>(file); }

H5FD_t* open_image(const char* /*name*/, unsigned /*flags*/, hid_t access_list, haddr_t /*limit*/) {
  const auto* image = static_cast<SparseImage* const*>(H5Pget_driver_info(access_list));
  if (image == nullptr) return nullptr;
  auto opened = std::make_unique<OpenImage>();
  opened->image = *image;
  return reinterpret_cast<H5FD_t*>(opened.release());
}

herr_t close_image(H5FD_t* file) {
  delete from(file);
  return 0;
}

herr_t tell_features(const H5FD_t* /*file*/, unsigned long* features) {
  *features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t end_of_allocation(const H5FD_t* file, H5FD_mem_t /*type*/) { return from(file)->end_of_allocation; }

herr_t set_end_of_allocation(H5FD_t* file, H5FD_mem_t /*type*/, haddr_t end) {
  from(file)->end_of_allocation = end;
  return 0;
}

haddr_t end_of_image(const H5FD_t* file, H5FD_mem_t /*type*/) { return from(file)->image->size(); }

// Exceptions must not pass through a library in C.
herr_t read_image(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*list*/, haddr_t at, size_t size, void* bytes) {
  from(file)->image->read(at, bytes, size);
  return 0;
}

herr_t write_image(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*list*/, haddr_t at, size_t size, const void* bytes) {
  try {
    from(file)->image->write(at, bytes, size);
  } catch (const std::exception&) {
    return -1;
  }
  return 0;
}

herr_t end_at_allocation(H5FD_t* file, hid_t /*list*/, hbool_t /*closing*/) {
  from(file)->image->resize(from(file)->end_of_allocation);
  return 0;
}

hid_t driver() {
  static const hid_t registered = [] {
    H5FD_class_t methods = {};
#if H5_VERSION_GE(1, 14, 0)
    // From 1.14 on the library refuses a driver that does not say which version of this interface it is made for. The
    // number is the first that is not for drivers of its own; no file holds it.
    methods.version = H5FD_CLASS_VERSION;
    methods.value = H5_VFD_RESERVED;
#endif
    methods.name = "granuscope sparse image";
    methods.maxaddr = HADDR_MAX;
    methods.fc_degree = H5F_CLOSE_WEAK;
    methods.fapl_size = sizeof(void*);  // the access list holds the address of an image
    methods.open = open_image;
    methods.close = close_image;
    methods.query = tell_features;
    methods.get_eoa = end_of_allocation;
    methods.set_eoa = set_end_of_allocation;
    methods.get_eof = end_of_image;
    methods.read = read_image;
    methods.write = write_image;
    methods.truncate = end_at_allocation;
    // The library keeps a pointer to this.
    static const H5FD_class_t kept = methods;
    return H5FDregister(&kept);
  }();
  return registered;
}

}  // namespace

void SparseImage::write(std::uint64_t at, const void* bytes, std::size_t size) {
  const auto* from_bytes = static_cast<const char*>(bytes);
  size_ = std::max(size_, at + size);
  while (size > 0) {
    std::vector<char>& page = pages_[at / page_bytes];
    if (page.empty()) page.resize(page_bytes);
    const std::size_t within = at % page_bytes, piece = std::min(size, page_bytes - within);
    std::copy_n(from_bytes, piece, page.begin() + static_cast<std::ptrdiff_t>(within));
    from_bytes += piece;
    at += piece;
    size -= piece;
  }
}

void SparseImage::read(std::uint64_t at, void* bytes, std::size_t size) const {
  auto* to = static_cast<char*>(bytes);
  while (size > 0) {
    const std::size_t within = at % page_bytes, piece = std::min(size, page_bytes - within);
    const auto page = pages_.find(at / page_bytes);
    if (page == pages_.end()) {
      std::fill_n(to, piece, '\0');
    } else {
      std::copy_n(page->second.begin() + static_cast<std::ptrdiff_t>(within), piece, to);
    }
    to += piece;
    at += piece;
    size -= piece;
  }
}

void SparseImage::for_each_page(const std::function<void(std::uint64_t at, std::span<const char> bytes)>& visit) const {
  for (const auto& [number, page] : pages_) {
    const std::uint64_t at = number * page_bytes;
    if (at >= size_) break;
    visit(at, std::span(page).first(std::min<std::uint64_t>(page.size(), size_ - at)));
  }
}

int set_sparse_driver(Hdf5Id access_list, SparseImage* image) {
  return H5Pset_driver(access_list, driver(), static_cast<const void*>(&image));
}

}  // namespace granuscope
