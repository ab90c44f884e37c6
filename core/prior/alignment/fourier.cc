// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/fourier.h"

#include <unsupported/Eigen/FFT>

namespace enfilade::prior {
namespace {

template <typename Step>
void ForEachLine(ComplexImage& image, const Step& step) {
  std::vector<std::complex<float>> in;
  std::vector<std::complex<float>> out;
  for (int row = 0; row < image.height; ++row) {
    const auto begin = image.values.begin() + static_cast<std::ptrdiff_t>(image.index(0, row));
    in.assign(begin, begin + image.width);
    step(out, in);
    std::copy(out.begin(), out.end(), begin);
  }
  in.resize(static_cast<std::size_t>(image.height));
  for (int column = 0; column < image.width; ++column) {
    for (int row = 0; row < image.height; ++row)
      in[static_cast<std::size_t>(row)] = image.values[image.index(column, row)];
    step(out, in);
    for (int row = 0; row < image.height; ++row)
      image.values[image.index(column, row)] = out[static_cast<std::size_t>(row)];
  }
}

}  // namespace

void Transform(ComplexImage& image) {
  Eigen::FFT<float> transform;
  ForEachLine(image, [&](auto& out, const auto& in) { transform.fwd(out, in); });
}

void TransformBack(ComplexImage& image) {
  Eigen::FFT<float> transform;
  ForEachLine(image, [&](auto& out, const auto& in) { transform.inv(out, in); });
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
