// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/pgm_codec.h"
#include "core/grid/files/plan_image.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  return {std::string("P5\n# a comment\n4 3\n255\n") + "abcdefghijkl", "P2\n3 2 15\n0 1 2\n13 14 15\n",
          std::string("P5 2 2 200\n\0\1\2\3\n", 16)};
}

bool Decode(std::string_view bytes) {
  (void)grid::ReadPlan(bytes);
  const auto image = grid::DecodePgm(bytes);
  if (!image.ok()) return false;
  Expect(image->pixels.size() == static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height),
         "as many pixels as announced");
  const std::string again =
      grid::EncodePgm({image->width, image->height, image->max_value, image->header, image->trailer}, image->pixels);
  if (bytes.starts_with("P5")) Expect(again == bytes, "a binary PGM is restored byte for byte");
  const auto same = grid::DecodePgm(again);
  Expect(same.ok() && same->pixels == image->pixels, "an image is read back");
  return true;
}

}  // namespace enfilade::fuzz
