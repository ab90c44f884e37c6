// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/fourier.h"

#include <algorithm>
#include <unsupported/Eigen/FFT>

namespace enfilade::prior {
namespace {

constexpr int kColumnsAtOnce = 16;  // which share cache lines

// `step(out, in, size)` transforms one line.
template <typename Step>
void ForEachLine(ComplexImage& image, const Step& step) {
  const auto width = static_cast<std::size_t>(image.width);
  const auto height = static_cast<std::size_t>(image.height);
  std::vector<std::complex<float>> in(std::max(width, height * kColumnsAtOnce));
  std::vector<std::complex<float>> out(height);
  for (std::size_t row = 0; row < height; ++row) {
    std::complex<float>* const line = image.values.data() + row * width;
    if (std::all_of(line, line + width, [](const auto& value) { return value == 0.0F; })) continue;
    std::copy(line, line + width, in.begin());
    step(line, in.data(), image.width);
  }
  for (std::size_t first = 0; first < width; first += kColumnsAtOnce) {
    const std::size_t count = std::min<std::size_t>(kColumnsAtOnce, width - first);
    for (std::size_t row = 0; row < height; ++row) {
      for (std::size_t i = 0; i < count; ++i) in[i * height + row] = image.values[row * width + first + i];
    }
    for (std::size_t i = 0; i < count; ++i) {
      step(out.data(), in.data() + i * height, image.height);
      std::copy(out.begin(), out.end(), in.begin() + static_cast<std::ptrdiff_t>(i * height));
    }
    for (std::size_t row = 0; row < height; ++row) {
      for (std::size_t i = 0; i < count; ++i) image.values[row * width + first + i] = in[i * height + row];
    }
  }
}

}  // namespace

void Transform(ComplexImage& image) {
  Eigen::FFT<float> transform;
  ForEachLine(image, [&](auto* out, const auto* in, int size) { transform.fwd(out, in, size); });
}

void TransformBack(ComplexImage& image) {
  Eigen::FFT<float> transform;
  ForEachLine(image, [&](auto* out, const auto* in, int size) { transform.inv(out, in, size); });
}

int QuickSize(int least) {
  for (int size = least;; ++size) {
    int rest = size;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return size;
  }
}

}  // namespace enfilade::prior
