// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/diff_picture.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/grid/diff/diff_lattice.h"

namespace enfilade::grid {
namespace {

// What a cell is in the picture. Of the cells of a pixel, the greatest wins.
enum Rank : std::uint8_t { kStaysUnknown, kStaysFree, kBecameFree, kStaysOccupied, kBecameUnknown, kWent, kCame };

constexpr Rgb kPaleUnknown{226, 231, 235};
constexpr Rgb kPaleFree{255, 255, 255};
constexpr Rgb kPaleNewlyFree{236, 246, 236};
constexpr Rgb kPaleOccupied{188, 193, 198};
constexpr Rgb kGrey{120, 126, 132};
constexpr std::array<Rgb, 7> kColors{kPaleUnknown, kPaleFree, kPaleNewlyFree, kPaleOccupied, kGrey, kRed, kGreen};

// 3 * from + to, by CellClass.
constexpr std::array<Rank, 9> kRanks{kStaysUnknown, kBecameFree, kCame, kBecameUnknown, kStaysFree,
                                     kCame,         kWent,       kWent, kStaysOccupied};

int PixelsOf(std::int64_t cells, int shift) { return static_cast<int>(((cells - 1) >> shift) + 1); }

}  // namespace

DiffPicture::DiffPicture(const DiffLattice& lattice, int max_side)
    : left_(lattice.min.column),
      bottom_(lattice.min.row),
      last_column_(lattice.max.column),
      last_row_(lattice.max.row),
      T_map_picture_(lattice.T_map_lattice * Pose2{left_ * lattice.resolution, bottom_ * lattice.resolution, 0.0}) {
  const std::int64_t columns = std::int64_t{last_column_} - left_ + 1;
  const std::int64_t rows = std::int64_t{last_row_} - bottom_ + 1;
  while (PixelsOf(std::max(columns, rows), shift_) > max_side) ++shift_;
  width_ = PixelsOf(columns, shift_);
  height_ = PixelsOf(rows, shift_);
  ranks_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kStaysUnknown);
}

void DiffPicture::Add(int row, int column, const std::uint8_t* base, const std::uint8_t* revision, int size) {
  if (row < bottom_ || row > last_row_) return;
  const int begin = std::max(0, left_ - column);
  const int end = std::min(size, last_column_ - column + 1);
  std::uint8_t* const pixels =
      ranks_.data() + static_cast<std::size_t>((row - bottom_) >> shift_) * static_cast<std::size_t>(width_);
  for (int i = begin; i < end; ++i) {
    const std::uint8_t rank = kRanks[3U * base[i] + revision[i]];
    std::uint8_t& pixel = pixels[(column + i - left_) >> shift_];
    pixel = std::max(pixel, rank);
  }
}

MapDiffPicture DiffPicture::Finish() && {
  MapDiffPicture picture{RgbImage(width_, height_, kPaleUnknown), 1 << shift_, T_map_picture_};
  auto sample = picture.image.samples.begin();
  for (int row = height_ - 1; row >= 0; --row) {
    const auto begin = ranks_.begin() + std::ptrdiff_t{row} * width_;
    for (auto rank = begin; rank != begin + width_; ++rank) sample = std::copy_n(kColors[*rank].begin(), 3, sample);
  }
  return picture;
}

}  // namespace enfilade::grid
