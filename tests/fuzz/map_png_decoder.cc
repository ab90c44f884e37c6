// SPDX-License-Identifier: Apache-2.0
// PNG images of maps and floor plans.
#include "core/grid/files/grey_image.h"
#include "core/grid/files/plan_image.h"
#include "core/grid/files/png_codec.h"
#include "tests/fuzz/decoder.h"
#include "tests/fuzz/png_repair.h"

namespace enfilade::fuzz {
namespace {

bool DecodeOne(std::string_view png) {
  const auto image = grid::DecodePng(png);
  for (const grid::MapDialect dialect : {grid::MapDialect::kNav2, grid::MapDialect::kRos1}) {
    Expect(grid::DecodeGreyPng(png, dialect).ok() == image.ok(), "both dialects read the same files");
  }
  const auto plan = grid::ReadPlan(png);  // of a PNG or a PGM
  if (!image.ok()) return false;
  Expect(plan.ok(), "a plan is any image");
  const auto again = grid::EncodePng(*image);
  if (!again.ok()) return true;  // a side above a million
  const auto same = grid::DecodePng(*again);
  Expect(same.ok() && *same == *image, "an image is read back");
  return true;
}

}  // namespace

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (int channels = 1; channels <= 4; ++channels) {
    grid::PixelImage image{.width = 9, .height = 7, .channels = channels, .samples = {}};
    for (int i = 0; i < 63 * channels; ++i) image.samples.push_back(static_cast<std::uint8_t>(i * 37));
    seeds.push_back(grid::EncodePng(image).value());
  }
  return seeds;
}

bool Decode(std::string_view bytes) {
  (void)DecodeOne(WithValidChecksums(bytes));
  return DecodeOne(bytes);
}

}  // namespace enfilade::fuzz
