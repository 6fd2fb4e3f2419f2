#include "render/png_file.h"

#include <fmt/format.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

namespace granuscope {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }  // errors are looked for before, by fflush
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// libpng reports through a callback and leaves by longjmp. No object with a destructor may then lie between the setjmp
/// and the call into libpng, so that everything with one lives in the callers of encode_...().
struct PngError {
  std::array<char, 256> message{};
};

extern "C" void note_png_error(png_structp png, png_const_charp message) {
  auto* error = static_cast<PngError*>(png_get_error_ptr(png));
  std::snprintf(error->message.data(), error->message.size(), "%s", message);
  std::longjmp(*png_set_longjmp_fn(png, std::longjmp, sizeof(std::jmp_buf)), 1);
}

extern "C" void ignore_png_warning(png_structp, png_const_charp) {}

/// zlib's level and strategy and libpng's row filter, by measurement of all levels and filters on every scene, piles of
/// 70 x 60, 500 x 200 and 1000 x 1000 beads at 800, 2000 and 8000 px. Oblique lines and discs on a page repeat as they
/// are, so that every filter enlarges the file (none 0.93 MB, up 1.00, sub 1.06, average 1.15, paeth 1.12, chosen row
/// by row 1.00: forces of 70 x 60 at 2000 px), and level 2 takes a third (0.023 s) of the time of level 6 (0.069 s) for
/// 10 % more bytes; level 9 takes twelve times as long as that for 1 % fewer. In greys, looking for runs alone (Z_RLE)
/// is faster by another 1.4 to 2.4 times with -21 to +14 % of the bytes (0.049 s and 2.60 MB become 0.020 s and 2.60
/// MB: forces of 1000 x 1000 at 2000 px); in colours, where a pixel takes several bytes, it finds none.
constexpr int compression_level = 2;
constexpr int row_filter = PNG_FILTER_NONE;
constexpr int grey_strategy = Z_RLE;

/// What the encoder holds between rows.
struct Encoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  PngError error;
  ~Encoder() { png_destroy_write_struct(&png, &info); }
};

bool encode_header(Encoder* to, std::FILE* file, const PngWriter::Form* form, png_text* texts, int text_count) {
  to->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &to->error, note_png_error, ignore_png_warning);
  if (to->png == nullptr) return false;
  to->info = png_create_info_struct(to->png);
  if (to->info == nullptr || setjmp(png_jmpbuf(to->png)) != 0) return false;
  constexpr double metres_per_inch = 0.0254;
  const auto pixels_per_metre = static_cast<png_uint_32>(std::lround(form->dpi / metres_per_inch));
  png_init_io(to->png, file);
  png_set_user_limits(to->png, PNG_USER_WIDTH_MAX, PNG_USER_HEIGHT_MAX);
  png_set_IHDR(to->png, to->info, static_cast<png_uint_32>(form->width), static_cast<png_uint_32>(form->height), 8,
               form->channels == Channels::grey  ? PNG_COLOR_TYPE_GRAY
               : form->channels == Channels::rgb ? PNG_COLOR_TYPE_RGB
                                                 : PNG_COLOR_TYPE_RGB_ALPHA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(to->png, to->info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_pHYs(to->png, to->info, pixels_per_metre, pixels_per_metre, PNG_RESOLUTION_METER);
  if (text_count > 0) png_set_text(to->png, to->info, texts, text_count);
  png_set_compression_level(to->png, compression_level);
  if (form->channels == Channels::grey) png_set_compression_strategy(to->png, grey_strategy);
  png_set_filter(to->png, PNG_FILTER_TYPE_BASE, row_filter);
  png_write_info(to->png, to->info);
  return true;
}

bool encode_row(Encoder* to, png_const_bytep row) {
  if (setjmp(png_jmpbuf(to->png)) != 0) return false;
  if (interruption_requested()) png_error(to->png, "interrupted");
  png_write_row(to->png, row);
  return true;
}

bool encode_end(Encoder* to) {
  if (setjmp(png_jmpbuf(to->png)) != 0) return false;
  png_write_end(to->png, nullptr);
  return true;
}

/// The stored channels of one row of pixels.
void pack(const std::uint8_t* pixels, int width, Channels channels, png_bytep row) {
  if (channels == Channels::grey) {
    for (int x = 0; x < width; ++x) row[x] = pixels[4 * x];
  } else if (channels == Channels::rgb) {
    for (int x = 0; x < width; ++x) {
      row[3 * x] = pixels[4 * x];
      row[3 * x + 1] = pixels[4 * x + 1];
      row[3 * x + 2] = pixels[4 * x + 2];
    }
  } else {
    std::memcpy(row, pixels, 4 * static_cast<std::size_t>(width));
  }
}

void require_keyword(const std::string& keyword) {
  const bool printable = std::ranges::all_of(keyword, [](char c) { return c >= ' ' && c <= '~'; });
  if (keyword.empty() || keyword.size() > 79 || !printable || keyword.front() == ' ' || keyword.back() == ' ') {
    throw InputError(
        "'{}' cannot be a keyword of a PNG: it must be 1 to 79 printable ASCII characters that neither start nor end "
        "with a blank",
        keyword);
  }
}

}  // namespace

struct PngWriter::State {
  State(const std::filesystem::path& path_, const Form& form_)
      : path(path_),
        form(form_),
        target(path),
        file(std::fopen(target.temporary_path().c_str(), "wb")),
        row(4 * static_cast<std::size_t>(form.width)) {}

  [[noreturn]] void fail() const {
    const int reason = errno;
    throw_if_interrupted();
    throw EnvironmentError("cannot write '{}': {} Nothing was left behind.", path.string(),
                           reason != 0 ? system_reason(reason) : fmt::format("{}.", encoder.error.message.data()));
  }

  std::filesystem::path path;
  Form form;
  AtomicFile target;
  File file;
  Encoder encoder;
  std::vector<png_byte> row;
};

PngWriter::PngWriter(const std::filesystem::path& path, const Form& form, const ImageMetadata& metadata) {
  if (form.width < 1 || form.height < 1) {
    throw InputError("an image of {} x {} pixels cannot be written to {}: it is empty", form.width, form.height,
                     path.string());
  }
  if (!(form.dpi > 0) || !std::isfinite(form.dpi)) {
    throw InputError("{} dpi is no resolution for an image", form.dpi);
  }
  ImageMetadata texts_owned = metadata;  // libpng asks for pointers it could write through
  std::vector<png_text> texts;
  for (auto& [keyword, text] : texts_owned) {
    require_keyword(keyword);
    png_text entry = {};
    entry.compression = PNG_ITXT_COMPRESSION_NONE;
    entry.key = keyword.data();
    entry.text = text.data();
    entry.itxt_length = text.size();
    texts.push_back(entry);
  }
  state_ = std::make_unique<State>(path, form);
  if (state_->file == nullptr) {
    throw EnvironmentError("cannot write {}: {}; choose a folder that exists and may be written to", path.string(),
                           std::generic_category().message(errno));
  }
  errno = 0;
  if (!encode_header(&state_->encoder, state_->file.get(), &form, texts.data(), static_cast<int>(texts.size()))) {
    state_->fail();
  }
}

PngWriter::~PngWriter() = default;

void PngWriter::add(const Image& rows) {
  if (rows.width != state_->form.width) throw std::logic_error("rows of another width than the PNG they are for");
  errno = 0;
  for (int y = 0; y < rows.height; ++y) {
    pack(rows.rgba.data() + rows.offset(0, y), rows.width, state_->form.channels, state_->row.data());
    if (!encode_row(&state_->encoder, state_->row.data())) state_->fail();
  }
}

void PngWriter::commit() {
  errno = 0;
  if (!encode_end(&state_->encoder) || std::fflush(state_->file.get()) != 0) state_->fail();
  state_->file.reset();
  state_->target.commit();
}

}  // namespace granuscope
