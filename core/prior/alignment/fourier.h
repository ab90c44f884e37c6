// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

namespace enfilade::prior {

// A complex image, row by row.
struct ComplexImage {
  int width = 0;
  int height = 0;
  std::vector<std::complex<float>> values;

  ComplexImage() = default;
  ComplexImage(int columns, int rows)
      : width(columns), height(rows), values(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
  }
};

// The discrete Fourier transform of a whole image, in place, and its inverse (scaled by 1 / size).
void Transform(ComplexImage& image);
void TransformBack(ComplexImage& image);

// The smallest size from `least` on that transforms quickly: 2, 3 and 5 are its only prime factors.
int QuickSize(int least);

}  // namespace enfilade::prior
