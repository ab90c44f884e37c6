// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace enfilade::perception {

// A picture of one byte per pixel; not 0: part of the skeleton.
struct SkeletonView {
  int width = 0;
  int height = 0;
  const std::uint8_t* pixels = nullptr;  // rows from the top, without gaps
  const float* half_width = nullptr;     // of the stroke at each pixel
};

// A line of the skeleton between two nodes.
struct Chain {
  int from = 0;
  int to = 0;
  std::vector<int> pixels;  // indices into the picture, in order, without those of the nodes
  bool dropped = false;
};

struct ChainGraph {
  std::vector<Eigen::Vector2d> nodes;  // px
  std::vector<double> node_half_width;
  std::vector<Chain> chains;
};

// The skeleton's lines. Stubs shorter than the stroke that they grow from is wide are left out.
ChainGraph FollowSkeleton(const SkeletonView& skeleton);

}  // namespace enfilade::perception
