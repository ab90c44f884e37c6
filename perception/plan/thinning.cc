// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <vector>

#include "perception/plan/opencv_thinning.h"

namespace enfilade::perception {
namespace {

// A pixel's eight neighbours as bits, clockwise from the one above.
using Neighbours = unsigned;

struct Offsets {
  explicit Offsets(int stride) : around{-stride, -stride + 1, 1, stride + 1, stride, stride - 1, -1, -stride - 1} {}
  std::array<int, 8> around;
};

Neighbours NeighboursAt(const uchar* pixel, const Offsets& offsets) {
  Neighbours bits = 0;
  for (unsigned i = 0; i < 8; ++i) bits |= (pixel[offsets.around[i]] != 0 ? 1U : 0U) << i;
  return bits;
}

int CountOf(Neighbours bits) { return __builtin_popcount(bits); }
bool Has(Neighbours bits, int i) { return (bits >> (i & 7)) & 1U; }

// How often the circle of neighbours changes from background to mask.
int ChangesOf(Neighbours bits) {
  int changes = 0;
  for (int i = 0; i < 8; ++i) changes += !Has(bits, i) && Has(bits, i + 1) ? 1 : 0;
  return changes;
}

// Zhang and Suen's conditions for both halves of a round.
struct Rules {
  std::array<std::array<bool, 256>, 2> removable{};
  std::array<bool, 256> redundant{};

  Rules() {
    for (Neighbours bits = 0; bits < 256; ++bits) {
      const bool border = CountOf(bits) >= 2 && CountOf(bits) <= 6 && ChangesOf(bits) == 1;
      const bool up = Has(bits, 0), right = Has(bits, 2), down = Has(bits, 4), left = Has(bits, 6);
      removable[0][bits] = border && !(up && right && down) && !(right && down && left);
      removable[1][bits] = border && !(up && right && left) && !(up && down && left);
      redundant[bits] = CountOf(bits) >= 2 && IsConnectedWithoutCentre(bits);
    }
  }

  // Whether the neighbours are connected among themselves (8-connected) and a side of the pixel is open.
  static bool IsConnectedWithoutCentre(Neighbours bits) {
    if (Has(bits, 0) && Has(bits, 2) && Has(bits, 4) && Has(bits, 6)) return false;
    int parts = 0;
    for (int i = 0; i < 8; i += 2) {
      // A side without mask whose following corner or side has some begins a part (Hilditch's crossing number).
      if (!Has(bits, i) && (Has(bits, i + 1) || Has(bits, i + 2))) ++parts;
    }
    return parts == 1;
  }
};

const Rules& TheRules() {
  static const Rules rules;
  return rules;
}

// Each round looks at the neighbours of what the last one removed.
class Thinning {
 public:
  explicit Thinning(const cv::Mat& mask) : offsets_(mask.cols + 2) {
    cv::copyMakeBorder(mask, image_, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    for (std::size_t i = 0; i < image_.total(); ++i) {
      if (image_.data[i] != 0 && NeighboursAt(&image_.data[i], offsets_) != 255) front_.push_back(static_cast<int>(i));
    }
    queued_.assign(image_.total(), 0);
  }

  cv::Mat Run() {
    int idle = 0;
    for (int half = 0; idle < 2; half ^= 1) idle = Peel(half) ? 0 : idle + 1;
    for (std::size_t i = 0; i < image_.total(); ++i) {
      if (image_.data[i] != 0 && TheRules().redundant[NeighboursAt(&image_.data[i], offsets_)]) image_.data[i] = 0;
    }
    return image_(cv::Rect(1, 1, image_.cols - 2, image_.rows - 2)).clone();
  }

 private:
  bool Peel(int half) {
    std::vector<int> removed, next;
    for (const int i : front_) {
      if (TheRules().removable[half][NeighboursAt(&image_.data[i], offsets_)]) removed.push_back(i);
    }
    for (const int i : removed) image_.data[i] = 0;
    const auto queue = [&](int i) {
      if (image_.data[i] == 0 || queued_[i]) return;
      queued_[i] = 1;
      next.push_back(i);
    };
    for (const int i : front_) queue(i);
    for (const int i : removed) {
      for (const int offset : offsets_.around) queue(i + offset);
    }
    for (const int i : next) queued_[i] = 0;
    front_ = std::move(next);
    return !removed.empty();
  }

  Offsets offsets_;
  cv::Mat image_;
  std::vector<int> front_;
  std::vector<uchar> queued_;
};

}  // namespace

cv::Mat Thin(const cv::Mat& mask) { return Thinning(mask).Run(); }

}  // namespace enfilade::perception
