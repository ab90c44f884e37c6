// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plans/drawn_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "client/simulator/plan/plan_drawing.h"
#include "core/grid/files/png_codec.h"

namespace enfilade::testing {
namespace {

using Eigen::Vector2d;

struct Piece {
  Vector2d a, b;
};

// m, y down. Gaps between pieces in one line are doors, listed beside them.
constexpr double kWide = 16, kDeep = 11, kUpper = 4.4, kLower = 6.4;

std::vector<Piece> WallPieces() {
  std::vector<Piece> walls = {{{0, 0}, {13, 0}},
                              {{13, 0}, {kWide, 2.5}},  // a corner cut off: a sloping wall
                              {{kWide, 2.5}, {kWide, kDeep}},
                              {{kWide, kDeep}, {0, kDeep}},
                              {{0, kDeep}, {0, 0}},
                              {{5, 0}, {5, kUpper}},
                              {{10, 0}, {10, kUpper}},
                              {{4, kLower}, {4, kDeep}},
                              {{8, kLower}, {8, kDeep}},
                              {{12, kLower}, {12, kDeep}}};
  for (const auto& [y, doors] : {std::pair{kUpper, std::vector<double>{1.5, 6.5, 12.5}},
                                 std::pair{kLower, std::vector<double>{1.0, 5.0, 9.0, 13.0}}}) {
    double from = 0;
    for (const double door : doors) {
      walls.push_back({{from, y}, {door, y}});
      from = door + 0.95;
    }
    walls.push_back({{from, y}, {kWide, y}});
  }
  return walls;
}

std::vector<Piece> DoorPieces() {
  std::vector<Piece> doors;
  for (const double x : {1.5, 6.5, 12.5}) doors.push_back({{x, kUpper}, {x + 0.95, kUpper}});
  for (const double x : {1.0, 5.0, 9.0, 13.0}) doors.push_back({{x, kLower}, {x + 0.95, kLower}});
  return doors;
}

void AddBox(const Vector2d& low, const Vector2d& size, std::vector<Piece>& lines) {
  const Vector2d corners[] = {low, low + Vector2d(size.x(), 0), low + size, low + Vector2d(0, size.y())};
  for (int i = 0; i < 4; ++i) lines.push_back({corners[i], corners[(i + 1) % 4]});
}

// Thin lines that are no walls.
std::vector<Piece> FurniturePieces() {
  std::vector<Piece> lines;
  AddBox({1.2, 1.0}, {1.6, 0.8}, lines);
  AddBox({6.5, 1.2}, {0.8, 1.4}, lines);
  AddBox({1.2, 8.2}, {1.5, 0.8}, lines);
  AddBox({9.0, 8.5}, {1.6, 0.9}, lines);
  for (const Piece& door : DoorPieces()) {  // a leaf that stands open, and its arc
    const double side = door.a.y() == kUpper ? -1 : 1;
    lines.push_back({door.a, door.a + Vector2d(0, side * 0.95)});
    for (int i = 0; i < 8; ++i) {
      const auto at = [&](int k) -> Vector2d {
        return door.a + 0.95 * Vector2d(std::cos(k * M_PI / 16), side * std::sin(k * M_PI / 16));
      };
      lines.push_back({at(i), at(i + 1)});
    }
  }
  for (int i = 0; i < 6; ++i) {  // letters
    const Vector2d at(5.6 + 0.3 * i, 9.2);
    lines.push_back({at, at + Vector2d(0.09, -0.25)});
    lines.push_back({at + Vector2d(0.09, -0.25), at + Vector2d(0.18, 0)});
  }
  return lines;
}

// A dimension line beside a wall from `a` to `b`, `away` from it: extension lines that touch the walls' centre lines,
// both crossing a little, a slanting tick at each crossing, and digits over the middle.
void AddDimension(const Vector2d& a, const Vector2d& b, const Vector2d& away, std::vector<Piece>& lines) {
  const Vector2d along = (b - a).normalized(), out = away.normalized();
  lines.push_back({a + away - 0.2 * along, b + away + 0.2 * along});
  for (const Vector2d& end : {a, b}) {
    lines.push_back({end, end + away + 0.2 * out});
    lines.push_back({end + away - 0.15 * (along + out), end + away + 0.15 * (along + out)});
  }
  for (int i = 0; i < 4; ++i) {
    const Vector2d at = (a + b) / 2 + away + 0.3 * i * along;
    lines.push_back({at, at + 0.3 * out});
    lines.push_back({at + 0.3 * out, at + 0.3 * out + 0.15 * along});
  }
}

std::vector<Piece> DimensionPieces() {
  std::vector<Piece> lines;
  AddDimension({0, kDeep}, {kWide, kDeep}, {0, 1.2}, lines);
  AddDimension({0, 0}, {0, kDeep}, {-1.2, 0}, lines);
  return lines;
}

// Dashes of 1.6 m and dots of 0.3 m. Where the line goes around a corner, it has no gaps.
std::vector<Piece> PlotPieces() {
  constexpr double kAway = 0.7, kDash = 1.6, kDot = 0.3, kGap = 0.35;
  const Vector2d corners[] = {
      {-kAway, -kAway}, {kWide + kAway, -kAway}, {kWide + kAway, kDeep + kAway}, {-kAway, kDeep + kAway}};
  std::vector<Piece> bars;
  for (int i = 0; i < 4; ++i) {
    const Vector2d from = corners[i], along = (corners[(i + 1) % 4] - from).normalized();
    const double length = (corners[(i + 1) % 4] - from).norm();
    double at = kDash / 2;
    bars.push_back({from, from + at * along});
    for (bool dot = true; at + kGap + kDash < length; dot = !dot) {
      const double piece = dot ? kDot : kDash;
      bars.push_back({from + (at + kGap) * along, from + (at + kGap + piece) * along});
      at += kGap + piece;
    }
    bars.push_back({from + std::max(at + kGap, length - kDash / 2) * along, from + length * along});
  }
  return bars;
}

double DistanceTo(const Vector2d& p, const Piece& piece) {
  const Vector2d along = piece.b - piece.a;
  const double share = std::clamp((p - piece.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (piece.a + share * along - p).norm();
}

class Drawing {
 public:
  explicit Drawing(const DrawnPlanOptions& options) : options_(options) {
    const double turn = options.turn_deg * M_PI / 180;
    turn_ << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::max()), high = -low;
    for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(kWide, 0), Vector2d(kWide, kDeep), Vector2d(0, kDeep)}) {
      low = low.cwiseMin(turn_ * corner * options.px_per_m);
      high = high.cwiseMax(turn_ * corner * options.px_per_m);
    }
    const double margin = options.dimensions || options.plot ? 2 * options.px_per_m : 30;  // px
    shift_ = Vector2d::Constant(margin) - low;
    plan_.width = static_cast<int>(std::ceil((high - low).x() + 2 * margin));
    plan_.height = static_cast<int>(std::ceil((high - low).y() + 2 * margin));
  }

  DrawnPlan Run() {
    for (const Piece& piece : WallPieces()) walls_.push_back({ToSheet(piece.a), ToSheet(piece.b)});
    if (options_.furniture) {
      for (const Piece& piece : FurniturePieces()) lines_.push_back({ToSheet(piece.a), ToSheet(piece.b)});
    }
    if (options_.dimensions) {
      for (const Piece& piece : DimensionPieces()) lines_.push_back({ToSheet(piece.a), ToSheet(piece.b)});
    }
    if (options_.plot) {
      for (const Piece& piece : PlotPieces()) bars_.push_back({ToSheet(piece.a), ToSheet(piece.b)});
    }
    grid::PixelImage image{.width = plan_.width, .height = plan_.height, .channels = 1, .samples = {}};
    for (int y = 0; y < plan_.height; ++y) {
      for (int x = 0; x < plan_.width; ++x) image.samples.push_back(BrightnessAt(Vector2d(x, y)));
    }
    plan_.png = grid::EncodePng(image).value();
    WriteTruth();
    return std::move(plan_);
  }

 private:
  Vector2d ToSheet(const Vector2d& p) const { return turn_ * p * options_.px_per_m + shift_; }

  // The share of a pixel that is inked, by the distance of its centre to the edge of the ink.
  static double Coverage(double distance_inside) { return std::clamp(distance_inside + 0.5, 0.0, 1.0); }

  std::uint8_t BrightnessAt(const Vector2d& p) const {
    const double thickness = options_.wall_m * options_.px_per_m;
    double signed_distance = std::numeric_limits<double>::max();
    for (const Piece& wall : walls_)
      signed_distance = std::min(signed_distance, simulator::DistanceToInk(p, wall.a, wall.b, thickness));
    double ink = options_.style == WallStyle::kFilled ? Coverage(-signed_distance)
                                                      : Coverage(options_.line_px / 2 - std::abs(signed_distance));
    for (const Piece& line : lines_) ink = std::max(ink, Coverage(options_.line_px / 2 - DistanceTo(p, line)));
    for (const Piece& bar : bars_) ink = std::max(ink, Coverage(-simulator::DistanceToInk(p, bar.a, bar.b, kBar)));
    const double paper = 1 + (options_.shade_at_edge - 1) * p.x() / plan_.width;
    const double brightness = options_.bright_lines ? 0.15 + 0.8 * ink : paper * (0.95 - 0.85 * ink);
    return static_cast<std::uint8_t>(std::lround(255 * brightness));
  }

  void WriteTruth() {
    const double thickness = options_.wall_m * options_.px_per_m;
    for (const Piece& wall : walls_) {
      const int from = static_cast<int>(plan_.truth.corners.size());
      plan_.truth.corners.push_back({wall.a});
      plan_.truth.corners.push_back({wall.b});
      plan_.truth.walls.push_back({.from = from, .to = from + 1, .thickness = thickness});
    }
    for (const Piece& door : DoorPieces()) plan_.truth.doors.push_back({ToSheet(door.a), ToSheet(door.b)});
    plan_.truth.metres_per_unit = 1 / options_.px_per_m;
  }

  const DrawnPlanOptions& options_;
  DrawnPlan plan_;
  Eigen::Matrix2d turn_;
  Vector2d shift_;
  static constexpr double kBar = 12;  // px
  std::vector<Piece> walls_, lines_, bars_;
};

}  // namespace

DrawnPlan DrawPlan(const DrawnPlanOptions& options) { return Drawing(options).Run(); }

}  // namespace enfilade::testing
