// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>

#include "opencv2/core.hpp"
#include "opencv2/imgcodecs.hpp"
#include "opencv2/imgproc.hpp"
#include "perception/image/frame.h"

namespace enfilade::perception::testing {

inline GreyFrame ToFrame(const cv::Mat& grey) {
  const cv::Mat whole = grey.clone();
  return {whole.cols, whole.rows, {whole.data, whole.data + whole.total()}};
}

// Random rectangles and discs: a place that looks like no other.
inline void Scribble(std::uint32_t seed, int shapes, const cv::Rect& where, cv::Mat& image) {
  std::mt19937 rng(seed);
  const auto draw = [&](int below) { return static_cast<int>(rng() % static_cast<unsigned>(below)); };
  cv::Mat part = image(where);
  for (int i = 0; i < shapes; ++i) {
    const cv::Point at(draw(where.width), draw(where.height));
    const cv::Scalar grey(draw(256));
    if (i % 2 == 0) {
      cv::rectangle(part, cv::Rect(at.x, at.y, 5 + draw(40), 5 + draw(40)), grey, cv::FILLED);
    } else {
      cv::circle(part, at, 3 + draw(16), grey, cv::FILLED);
    }
  }
}

inline cv::Mat Place(std::uint32_t seed, cv::Size size = {512, 384}) {
  cv::Mat image(size, CV_8U, cv::Scalar(120));
  Scribble(seed, size.area() / 800, {0, 0, size.width, size.height}, image);
  cv::GaussianBlur(image, image, {}, 1.0);
  return image;
}

// The same place seen from the side: its corners move by up to `shift` pixels; with noise and another exposure.
inline cv::Mat SeenAgain(const cv::Mat& image, std::uint32_t seed, float shift = 40.0F) {
  std::mt19937 rng(seed);
  const auto move = [&] { return shift * (static_cast<float>(rng() % 2001) / 1000.0F - 1.0F); };
  const auto width = static_cast<float>(image.cols);
  const auto height = static_cast<float>(image.rows);
  const std::vector<cv::Point2f> from = {{0, 0}, {width, 0}, {width, height}, {0, height}};
  std::vector<cv::Point2f> to;
  for (const cv::Point2f& corner : from) to.emplace_back(corner.x + move(), corner.y + move());
  cv::Mat seen;
  cv::warpPerspective(image, seen, cv::getPerspectiveTransform(from, to), image.size(), cv::INTER_LINEAR,
                      cv::BORDER_CONSTANT, cv::Scalar(100));
  seen.convertTo(seen, CV_8U, 0.9, 8.0);
  cv::Mat noise(image.size(), CV_16S);
  cv::RNG generator(seed);
  generator.fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
  cv::add(seen, noise, seen, cv::noArray(), CV_8U);
  return seen;
}

// One of many doors alike in a wall of repeated tiles; `seed` is of the little that differs beside it.
inline cv::Mat DoorInTiles(std::uint32_t seed, int distinct_shapes) {
  cv::Mat image(384, 512, CV_8U, cv::Scalar(150));
  for (int y = 0; y < image.rows; y += 24) {
    for (int x = 0; x < image.cols; x += 24) {
      cv::rectangle(image, cv::Rect(x + 1, y + 1, 22, 22), cv::Scalar(185), cv::FILLED);
      cv::circle(image, {x + 12, y + 12}, 5, cv::Scalar(110), cv::FILLED);
      cv::line(image, {x + 3, y + 3}, {x + 9, y + 5}, cv::Scalar(60));
    }
  }
  cv::rectangle(image, cv::Rect(176, 96, 160, 288), cv::Scalar(70), cv::FILLED);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 2; ++column) {
      cv::rectangle(image, cv::Rect(188 + 72 * column, 110 + 66 * row, 60, 54), cv::Scalar(95), 3);
    }
  }
  if (distinct_shapes > 0) {
    Scribble(seed, distinct_shapes, {10, 60, 150, 160}, image);
    Scribble(seed + 1000, distinct_shapes, {350, 90, 150, 160}, image);
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  return image;
}

}  // namespace enfilade::perception::testing
