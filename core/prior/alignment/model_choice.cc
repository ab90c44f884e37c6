// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/model_choice.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/prior/alignment/agreement.h"
#include "core/prior/alignment/refine.h"

namespace enfilade::prior {
namespace {

constexpr int kHalvings = 3;                // into 8 blocks
constexpr std::size_t kFewestInBlock = 40;  // points
constexpr double kReach = 1.0;              // m, from where on a wall is not explained at all

using Block = std::vector<WallPoint>;

// Halves the walls across their longer extent, again and again: blocks with as many points each.
void Divide(Block walls, int halvings, std::vector<Block>& blocks) {
  if (halvings == 0) {
    blocks.push_back(std::move(walls));
    return;
  }
  Eigen::Array2d mean = Eigen::Array2d::Zero();
  Eigen::Array2d squares = Eigen::Array2d::Zero();
  for (const WallPoint& wall : walls) {
    mean += wall.point.array() / static_cast<double>(walls.size());
    squares += wall.point.array().square() / static_cast<double>(walls.size());
  }
  const Eigen::Array2d variance = squares - mean.square();
  const int axis = variance.x() >= variance.y() ? 0 : 1;
  const auto middle = walls.begin() + static_cast<std::ptrdiff_t>(walls.size() / 2);
  std::nth_element(walls.begin(), middle, walls.end(),
                   [&](const WallPoint& a, const WallPoint& b) { return a.point(axis) < b.point(axis); });
  Divide(Block(walls.begin(), middle), halvings - 1, blocks);
  Divide(Block(middle, walls.end()), halvings - 1, blocks);
}

MapEvidence AllBut(const std::vector<Block>& blocks, std::size_t held_back, double spacing) {
  MapEvidence others;
  others.spacing = spacing;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (i != held_back) others.walls.insert(others.walls.end(), blocks[i].begin(), blocks[i].end());
  }
  return others;
}

// What a plan leaves unexplained of walls: 0 to 1.
double LossOf(const std::vector<WallFace>& faces_sheet, const PlanTransform& T_map_sheet, const Block& walls) {
  const FaceIndex index(Transformed(faces_sheet, T_map_sheet), kReach);
  double loss = 0;
  double weight = 0;
  for (const WallPoint& wall : walls) {
    weight += wall.straightness;
    const Eigen::Vector2d along = wall.straightness > kStraight ? wall.along : Eigen::Vector2d::Zero();
    const auto nearest = index.Nearest(wall.point, along, kParallel, wall.open);
    const double d = nearest ? nearest->distance / kNearSigma : kReach / kNearSigma;
    loss += wall.straightness * (1 - std::exp(-0.5 * d * d));
  }
  return weight > 0 ? loss / weight : 0;
}

std::vector<double> HeldBackLosses(const std::vector<WallFace>& faces_sheet, const std::vector<Block>& blocks,
                                   double spacing, const PlacedModel& fitted) {
  const RefineOptions refining{.model = fitted.model, .widest = 1.0, .rounds = 8, .most_points = 1500};
  std::vector<double> losses;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const PlanTransform without = Refine(faces_sheet, AllBut(blocks, i, spacing), fitted.T_map_sheet, refining);
    losses.push_back(LossOf(faces_sheet, without, blocks[i]));
  }
  return losses;
}

bool IsBorneOut(const std::vector<double>& freer, const std::vector<double>& simpler) {
  const auto count = static_cast<double>(freer.size());
  double mean = 0;
  double squares = 0;
  for (std::size_t i = 0; i < freer.size(); ++i) mean += (simpler[i] - freer[i]) / count;
  for (std::size_t i = 0; i < freer.size(); ++i) {
    const double off = simpler[i] - freer[i] - mean;
    squares += off * off;
  }
  return mean > 0 && mean * mean > squares / (count * (count - 1));
}

// The axes at right angles, by as much each. `fixed_map` stays in place.
PlanTransform WithoutShear(const PlanTransform& T_map_sheet, const Eigen::Vector2d& fixed_map) {
  const Eigen::Vector2d x = T_map_sheet.linear.col(0).normalized();
  const Eigen::Vector2d y = T_map_sheet.linear.col(1).normalized();
  const double side = T_map_sheet.mirrored() ? 1 : -1;
  const Eigen::Vector2d along = (x + side * Eigen::Vector2d(y.y(), -y.x())).normalized();
  Eigen::Matrix2d linear;
  linear.col(0) = T_map_sheet.linear.col(0).norm() * along;
  linear.col(1) = T_map_sheet.linear.col(1).norm() * side * Eigen::Vector2d(-along.y(), along.x());
  return {linear, fixed_map - linear * ToSheet(T_map_sheet, fixed_map)};
}

}  // namespace

PlacedModel ChooseModel(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, const PlacedModel& start,
                        TransformModel widest) {
  std::vector<Block> blocks;
  Divide(evidence.walls, kHalvings, blocks);
  if (blocks.front().size() < kFewestInBlock) return start;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const WallPoint& wall : evidence.walls) centre += wall.point / static_cast<double>(evidence.walls.size());

  PlacedModel chosen;
  std::vector<double> least;
  for (const TransformModel model :
       {TransformModel::kSimilarity, TransformModel::kAnisotropic, TransformModel::kAffine}) {
    if (FreedomOf(model) > FreedomOf(widest)) break;
    PlacedModel next{start.T_map_sheet, model};
    if (model == TransformModel::kSimilarity) next.T_map_sheet = AsSimilarity(start.T_map_sheet, centre);
    if (model == TransformModel::kAnisotropic) next.T_map_sheet = WithoutShear(start.T_map_sheet, centre);
    next.T_map_sheet = Refine(faces_sheet, evidence, next.T_map_sheet, {.model = model, .widest = 1.0});
    std::vector<double> losses = HeldBackLosses(faces_sheet, blocks, evidence.spacing, next);
    if (least.empty() || IsBorneOut(losses, least)) {
      chosen = next;
      least = std::move(losses);
    }
  }
  return chosen;
}

}  // namespace enfilade::prior
