#include "core/grid/grey_image.h"

#include <algorithm>
#include <array>
#include <utility>

namespace enfilade {
namespace {

constexpr std::uint8_t kOpaque = 255;

std::uint8_t GreyOf(int r, int g, int b, MapDialect dialect) {
  if (dialect == MapDialect::kRos1) return static_cast<std::uint8_t>((2 * (r + g + b) + 3) / 6);
  return static_cast<std::uint8_t>((306 * r + 601 * g + 117 * b + 512) / 1024);
}

struct Conversion {
  bool has_color = false;
  bool has_transparency = false;
};

// One row of `channels` samples a pixel; `alpha` may be null.
void ConvertRow(const std::uint8_t* samples, int width, int channels, MapDialect dialect, std::uint8_t* grey,
                std::uint8_t* alpha, Conversion& conversion) {
  const bool is_color = channels >= 3;
  for (int column = 0; column < width; ++column, samples += channels) {
    if (is_color) {
      conversion.has_color |= samples[0] != samples[1] || samples[1] != samples[2];
      grey[column] = GreyOf(samples[0], samples[1], samples[2], dialect);
    } else {
      grey[column] = samples[0];
    }
    if (alpha != nullptr) {
      alpha[column] = samples[channels - 1];
      conversion.has_transparency |= alpha[column] != kOpaque;
    }
  }
}

}  // namespace

GreyFromPixels GreyFromImage(const PixelImage& image, MapDialect dialect) {
  const auto width = static_cast<std::size_t>(image.width);
  const auto height = static_cast<std::size_t>(image.height);
  const bool has_alpha = image.channels == 2 || image.channels == 4;
  GreyFromPixels result;
  result.cells.grey.resize(width * height);
  if (has_alpha) result.cells.alpha.resize(width * height);
  Conversion conversion;
  for (std::size_t row = 0; row < height; ++row) {
    const std::size_t from_bottom = (height - 1 - row) * width;
    ConvertRow(image.samples.data() + row * width * static_cast<std::size_t>(image.channels), image.width,
               image.channels, dialect, result.cells.grey.data() + from_bottom,
               has_alpha ? result.cells.alpha.data() + from_bottom : nullptr, conversion);
  }
  if (!conversion.has_transparency && dialect == MapDialect::kNav2) result.cells.alpha = {};
  if (conversion.has_color) result.warnings.push_back("the image's colours were turned into greys");
  return result;
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
  if (has_unknown && saved[kUnknownCell].alpha != kOpaque) {
    cells.alpha.resize(occupancy.size());
    for (std::size_t i = 0; i < occupancy.size(); ++i) cells.alpha[i] = saved[occupancy[i]].alpha;
  }
  return cells;
}

}  // namespace enfilade
