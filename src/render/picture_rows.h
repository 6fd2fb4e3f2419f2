#pragma once
#include <functional>

#include "render/image.h"

namespace granuscope {

/// The rows of a picture on their way from the painter to whoever takes them, so that only some are in memory. They are
/// opened blank from the top, painted on, finished with what lies over them, and passed on when the next are opened.
class PictureRows {
 public:
  /// An image of whole rows, the first of them at row `top` of the picture.
  using Rows = std::function<void(Image& rows, int top)>;

  /// `finish` paints over rows that are complete otherwise, `take` gets them; either may be empty.
  PictureRows(int width, int height, Rgb blank, std::uint8_t alpha, Rows finish, Rows take);

  /// The next rows, at most those that are left; valid until the next call.
  Image& open(int rows);
  /// Opens and passes on blank rows.
  void pass(int rows);
  /// Passes on the last rows.
  void close();
  int opened() const { return next_; }

 private:
  Image rows_;
  int width_, height_;
  Rgb blank_;
  std::uint8_t alpha_;
  Rows finish_, take_;
  int top_ = 0, next_ = 0;
};

/// Rows that are passed on together where nothing else says how many: some MB of the widest picture.
inline constexpr int rows_at_once = 64;

}  // namespace granuscope
