#include "report/zip_file.h"

#include <fmt/format.h>
#include <zip.h>

#include <cstdio>
#include <ctime>
#include <memory>

#include "support/atomic_file.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// A zip keeps the local time without its zone: the moment at which clocks here show the given one.
std::time_t moment_shown_as(const std::string& time) {
  std::tm parts = {};
  if (std::sscanf(time.c_str(), "%d-%d-%dT%d:%d:%d",  // NOLINT(cert-err34-c): a field that is missing is 0
                  &parts.tm_year, &parts.tm_mon, &parts.tm_mday, &parts.tm_hour, &parts.tm_min, &parts.tm_sec) < 3) {
    parts = std::tm();
    parts.tm_mday = parts.tm_mon = 1;
    parts.tm_year = 1980;
  }
  parts.tm_year -= 1900;
  parts.tm_mon -= 1;
  parts.tm_isdst = -1;
  return std::mktime(&parts);
}

}  // namespace

void write_zip(const std::filesystem::path& target, const std::vector<ZipEntry>& entries, const std::string& time) {
  AtomicFile file(target);
  const auto fail = [&](const std::string& why) {
    throw EnvironmentError(
        fmt::format("cannot write '{}': {}; make room or choose another --out", target.string(), why));
  };
  int code = 0;
  std::unique_ptr<zip_t, void (*)(zip_t*)> archive(
      zip_open(file.temporary_path().c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code), zip_discard);
  if (archive == nullptr) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    fail(why);
  }
  const std::time_t moment = moment_shown_as(time);
  for (const ZipEntry& entry : entries) {
    zip_source_t* source = entry.file.empty()
                               ? zip_source_buffer(archive.get(), entry.bytes.data(), entry.bytes.size(), 0)
                               : zip_source_file(archive.get(), entry.file.c_str(), 0, -1);
    if (source == nullptr) fail(zip_strerror(archive.get()));
    const zip_int64_t index = zip_file_add(archive.get(), entry.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(source);
      fail(zip_strerror(archive.get()));
    }
    const auto place = static_cast<zip_uint64_t>(index);
    constexpr zip_uint32_t plain_file = 0100644U << 16U;
    if (zip_file_set_mtime(archive.get(), place, moment, 0) != 0 ||
        zip_file_set_external_attributes(archive.get(), place, 0, ZIP_OPSYS_UNIX, plain_file) != 0) {
      fail(zip_strerror(archive.get()));
    }
  }
  // Only here are files read and the archive written, beside its place.
  if (zip_close(archive.get()) != 0) fail(zip_strerror(archive.get()));
  (void)archive.release();
  file.commit();
}

}  // namespace granuscope
