// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/grey_image.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"

namespace enfilade::grid {
namespace {

std::uint8_t GreyOf(int r, int g, int b, MapDialect dialect) {
  if (dialect == MapDialect::kRos1) return static_cast<std::uint8_t>((2 * (r + g + b) + 3) / 6);
  return static_cast<std::uint8_t>((306 * r + 601 * g + 117 * b + 512) / 1024);
}

class GreyReceiver : public PixelReceiver {
 public:
  explicit GreyReceiver(MapDialect dialect) : dialect_(dialect) {}

  void Begin(int width, int height, int channels) override {
    width_ = width;
    height_ = height;
    channels_ = channels;
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    cells_.grey.resize(count);
    if (channels == 2 || channels == 4) cells_.alpha.resize(count);
  }

  void Row(int row, const std::uint8_t* samples) override {
    const std::ptrdiff_t begin = std::ptrdiff_t{height_ - 1 - row} * width_;
    std::uint8_t* const grey = cells_.grey.data() + begin;
    std::uint8_t* const alpha = cells_.alpha.empty() ? nullptr : cells_.alpha.data() + begin;
    if (channels_ == 1) std::copy(samples, samples + width_, grey);
    for (int column = 0; column < width_ && channels_ > 1; ++column, samples += channels_) {
      grey[column] = channels_ == 2 ? samples[0] : GreyOf(samples[0], samples[1], samples[2], dialect_);
      has_color_ |= channels_ != 2 && (samples[0] != samples[1] || samples[1] != samples[2]);
      if (alpha == nullptr) continue;
      alpha[column] = samples[channels_ - 1];
      has_transparency_ |= alpha[column] != kOpaqueAlpha;
    }
  }

  GreyImage Finish() {
    GreyImage image{width_, height_, std::move(cells_), {}};
    if (!has_transparency_ && dialect_ == MapDialect::kNav2) image.cells.alpha = {};
    if (has_color_) image.warnings.push_back("the image's colours were converted to grey");
    return image;
  }

 private:
  MapDialect dialect_;
  int width_ = 0;
  int height_ = 0;
  int channels_ = 1;
  bool has_color_ = false;
  bool has_transparency_ = false;
  GreyCells cells_;
};

}  // namespace

absl::StatusOr<GreyImage> DecodeGreyPng(std::string_view png, MapDialect dialect) {
  GreyReceiver receiver(dialect);
  ENFILADE_RETURN_IF_ERROR(ReadPng(png, receiver));
  return receiver.Finish();
}

absl::StatusOr<std::string> EncodeGreyPng(const GreyCells& cells, int width, int height) {
  const std::ptrdiff_t row_length = width;
  const std::ptrdiff_t top = row_length * (height - 1);
  if (cells.alpha.empty() && cells.max_value == 255) {
    return EncodePng(PixelRows{
        .width = width, .height = height, .channels = 1, .top_row = cells.grey.data() + top, .stride = -row_length});
  }
  const int channels = cells.alpha.empty() ? 1 : 4;
  std::vector<std::uint8_t> samples;
  samples.reserve(cells.grey.size() * static_cast<std::size_t>(channels));
  for (std::size_t i = 0; i < cells.grey.size(); ++i) {
    const auto grey = static_cast<std::uint8_t>((2 * cells.grey[i] * 255 + cells.max_value) / (2 * cells.max_value));
    samples.insert(samples.end(), static_cast<std::size_t>(channels == 1 ? 1 : 3), grey);
    if (channels == 4) samples.push_back(cells.alpha[i]);
  }
  return EncodePng(PixelRows{.width = width,
                             .height = height,
                             .channels = channels,
                             .top_row = samples.data() + top * channels,
                             .stride = -row_length * channels});
}

GreyCells SaveAsGrey(const std::vector<std::uint8_t>& occupancy, const GreySaveOptions& options) {
  std::array<GreyAlpha, 256> saved;
  for (std::size_t cell = 0; cell < saved.size(); ++cell) {
    saved[cell] = SavedGrey(options, OccupancyValueOfCell(static_cast<std::uint8_t>(cell)));
  }
  GreyCells cells;
  cells.interpretation = InterpretationOfSaved(options);
  cells.grey.resize(occupancy.size());
  for (std::size_t i = 0; i < occupancy.size(); ++i) cells.grey[i] = saved[occupancy[i]].grey;
  const bool has_unknown = std::find(occupancy.begin(), occupancy.end(), kUnknownCell) != occupancy.end();
  if (has_unknown && saved[kUnknownCell].alpha != kOpaqueAlpha) {
    cells.alpha.resize(occupancy.size());
    for (std::size_t i = 0; i < occupancy.size(); ++i) cells.alpha[i] = saved[occupancy[i]].alpha;
  }
  return cells;
}

}  // namespace enfilade::grid
