// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "perception/plan/opencv_ink.h"

namespace enfilade::perception {
namespace {

constexpr int kWidth = 800, kHeight = 600;

Ink BlankInk() { return {cv::Mat::zeros(kHeight, kWidth, CV_8U), cv::Mat::zeros(kHeight, kWidth, CV_8U)}; }

void AddBar(Ink& ink, int x, int y, int width, int height) { ink.strokes(cv::Rect(x, y, width, height)) = 255; }

int AreaAfterErasing(Ink ink) {
  EraseDashedLines(ink);
  return cv::countNonZero(ink.strokes);
}

TEST(EraseDashedLines, TakesDashesAndDotsInARowAway) {
  Ink ink = BlankInk();
  for (int x = 100; x < 600; x += 70) {
    AddBar(ink, x, 300, 40, 4);
    AddBar(ink, x + 52, 300, 5, 4);
  }
  EXPECT_EQ(AreaAfterErasing(ink), 0);
}

TEST(EraseDashedLines, LeavesFewBarsInARowAndGapsThatDiffer) {
  Ink ink = BlankInk();
  for (int i = 0; i < 4; ++i) AddBar(ink, 100 + 60 * i, 100, 40, 4);
  int x = 100;
  for (const int gap : {3, 25, 9, 28, 4, 16, 30}) {
    AddBar(ink, x, 400, 40, 4);
    x += 40 + gap;
  }
  const int area = cv::countNonZero(ink.strokes);
  EXPECT_EQ(AreaAfterErasing(ink), area);
}

TEST(EraseDashedLines, LeavesBarsThatOtherWallsMeet) {
  // As walls between doors do, behind which there are rooms.
  Ink ink = BlankInk();
  for (int x = 100; x < 600; x += 60) {
    AddBar(ink, x, 300, 40, 4);
    AddBar(ink, x + 18, 300, 4, 60);
  }
  const int area = cv::countNonZero(ink.strokes);
  EXPECT_EQ(AreaAfterErasing(ink), area);
}

TEST(EraseDashedLines, TakesTheCornersOfADashedBoundaryAwayAndLeavesThinnerWalls) {
  Ink ink = BlankInk();
  for (int x = 150; x < 600; x += 70) AddBar(ink, x, 100, 40, 12);
  AddBar(ink, 60, 100, 60, 12);
  AddBar(ink, 60, 100, 12, 60);
  AddBar(ink, 200, 200, 300, 4);
  EXPECT_EQ(AreaAfterErasing(ink), 300 * 4);
}

TEST(EraseDashedLines, LeavesWallsAsWideAsADashedLine) {
  Ink ink = BlankInk();
  for (int x = 150; x < 600; x += 70) AddBar(ink, x, 100, 40, 12);
  AddBar(ink, 100, 200, 600, 12);
  AddBar(ink, 100, 500, 600, 12);
  EXPECT_EQ(AreaAfterErasing(ink), 2 * 600 * 12);
}

}  // namespace
}  // namespace enfilade::perception
