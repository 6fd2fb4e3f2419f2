#include "render/picture_rows.h"

#include <algorithm>
#include <utility>

namespace granuscope {

PictureRows::PictureRows(int width, int height, Rgb blank, std::uint8_t alpha, Rows finish, Rows take)
    : width_(width),
      height_(height),
      blank_(blank),
      alpha_(alpha),
      finish_(std::move(finish)),
      take_(std::move(take)) {}

Image& PictureRows::open(int rows) {
  close();
  rows_.width = width_;
  rows_.height = std::min(rows, height_ - next_);
  rows_.fill(blank_, alpha_);
  top_ = next_;
  next_ += rows_.height;
  return rows_;
}

void PictureRows::pass(int rows) {
  for (const int end = std::min(next_ + rows, height_); next_ < end;) open(std::min(rows_at_once, end - next_));
}

void PictureRows::close() {
  if (rows_.height == 0) return;
  if (finish_) finish_(rows_, top_);
  if (take_) take_(rows_, top_);
  rows_.height = 0;
}

}  // namespace granuscope
