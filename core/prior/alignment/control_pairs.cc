// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/control_pairs.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {
namespace {

constexpr std::size_t kMostPairs = 1000;  // each is tried without
constexpr double kLeastBaseline = 2.0;    // m
constexpr double kLeastShare = 0.05;      // of the sheet
constexpr std::size_t kFewestForAxes = 4;
constexpr std::size_t kFewestForWrong = 5;
constexpr double kMirrorGain = 3.0;  // how much smaller the residual of a mirrored plan must be
constexpr double kWrongSigmas = 4.0;
constexpr double kAxisRatios[] = {0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4};

// A similarity has the matrix [a, b; b, -a] (sheets' y points down), or [a, -b; b, a] if mirrored: linear in a, b, x,
// y.
PlanTransform FitSimilarity(const std::vector<ControlPair>& pairs, bool mirrored) {
  Eigen::MatrixXd rows(2 * static_cast<Eigen::Index>(pairs.size()), 4);
  Eigen::VectorXd values(rows.rows());
  const double sign = mirrored ? -1 : 1;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(pairs.size()); ++i) {
    const ControlPair& pair = pairs[static_cast<std::size_t>(i)];
    rows.row(2 * i) << pair.point_sheet.x(), sign * pair.point_sheet.y(), 1, 0;
    rows.row(2 * i + 1) << -sign * pair.point_sheet.y(), pair.point_sheet.x(), 0, 1;
    values.segment<2>(2 * i) = pair.point_map;
  }
  const Eigen::Vector4d solved = rows.colPivHouseholderQr().solve(values);
  PlanTransform transform;
  transform.linear << solved(0), sign * solved(1), solved(1), -sign * solved(0);
  transform.offset = solved.tail<2>();
  return transform;
}

// `ratio`: of the scale along the sheet's y by that along its x.
PlanTransform FitWithRatio(std::vector<ControlPair> pairs, bool mirrored, double ratio) {
  for (ControlPair& pair : pairs) pair.point_sheet.y() *= ratio;
  PlanTransform transform = FitSimilarity(pairs, mirrored);
  transform.linear.col(1) *= ratio;
  return transform;
}

double RmsOf(const PlanTransform& transform, const std::vector<ControlPair>& pairs) {
  double sum = 0;
  for (const ControlPair& pair : pairs) sum += (transform(pair.point_sheet) - pair.point_map).squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

PlanTransform FitEitherWay(const std::vector<ControlPair>& pairs) {
  const PlanTransform straight = FitSimilarity(pairs, false);
  // Two pairs fit both ways exactly.
  if (pairs.size() < 3) return straight;
  const PlanTransform mirrored = FitSimilarity(pairs, true);
  return RmsOf(straight, pairs) > std::max(kClickSigma, kMirrorGain * RmsOf(mirrored, pairs)) ? mirrored : straight;
}

// R diag(x, y): alternates between both scales for a turn, and the turn for both scales (a Procrustes problem).
PlanTransform FitAxes(const std::vector<ControlPair>& pairs, const PlanTransform& start) {
  Eigen::Vector2d sheet_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d map_mean = Eigen::Vector2d::Zero();
  for (const ControlPair& pair : pairs) {
    sheet_mean += pair.point_sheet / static_cast<double>(pairs.size());
    map_mean += pair.point_map / static_cast<double>(pairs.size());
  }
  Eigen::Vector2d scales(start.scale(), start.mirrored() ? start.scale() : -start.scale());
  double turn = std::atan2(start.linear(1, 0), start.linear(0, 0));
  for (int round = 0; round < 50; ++round) {
    const Eigen::Rotation2Dd to_sheet(-turn);
    Eigen::Vector2d cross = Eigen::Vector2d::Zero();
    Eigen::Vector2d squares = Eigen::Vector2d::Zero();
    for (const ControlPair& pair : pairs) {
      const Eigen::Vector2d sheet = pair.point_sheet - sheet_mean;
      cross += sheet.cwiseProduct(to_sheet * (pair.point_map - map_mean));
      squares += sheet.cwiseProduct(sheet);
    }
    scales = cross.cwiseQuotient(squares);
    double sine = 0;
    double cosine = 0;
    for (const ControlPair& pair : pairs) {
      const Eigen::Vector2d own = scales.cwiseProduct(pair.point_sheet - sheet_mean);
      const Eigen::Vector2d map = pair.point_map - map_mean;
      cosine += own.dot(map);
      sine += own.x() * map.y() - own.y() * map.x();
    }
    turn = std::atan2(sine, cosine);
  }
  PlanTransform transform;
  transform.linear = Eigen::Rotation2Dd(turn).toRotationMatrix() * scales.asDiagonal();
  transform.offset = map_mean - transform.linear * sheet_mean;
  return transform;
}

// Do the pairs determine both scales: does the sheet's spread across its main axis reach a quarter of that along it?
bool AreSpread(const std::vector<ControlPair>& pairs) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const ControlPair& pair : pairs) mean += pair.point_sheet / static_cast<double>(pairs.size());
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  for (const ControlPair& pair : pairs) squares += (pair.point_sheet - mean).cwiseAbs2();
  return squares.minCoeff() > squares.maxCoeff() / 16;
}

struct Fit {
  PlanTransform transform;
  TransformModel model = TransformModel::kSimilarity;
};

Fit FitTo(const std::vector<ControlPair>& pairs, TransformModel widest) {
  Fit fit{FitEitherWay(pairs)};
  if (widest == TransformModel::kSimilarity || pairs.size() < kFewestForAxes || !AreSpread(pairs)) return fit;
  // Only if clicks do not explain what the similarity leaves.
  if (RmsOf(fit.transform, pairs) < kClickSigma) return fit;
  return {FitAxes(pairs, fit.transform), TransformModel::kAnisotropic};
}

std::vector<ControlPair> Without(const std::vector<ControlPair>& pairs, std::size_t left_out) {
  std::vector<ControlPair> others = pairs;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
  return others;
}

// The pair without which the others agree, if there is one.
std::optional<std::size_t> FindWrong(const std::vector<ControlPair>& pairs, TransformModel widest) {
  if (pairs.size() < kFewestForWrong) return std::nullopt;
  std::optional<std::size_t> wrong;
  double least = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::vector<ControlPair> others = Without(pairs, i);
    const PlanTransform fit = FitEitherWay(others);
    const double rms = RmsOf(fit, others);
    if (wrong && rms >= least) continue;
    wrong = i;
    least = rms;
  }
  const PlanTransform fit = FitTo(Without(pairs, *wrong), widest).transform;
  const double missed = (fit(pairs[*wrong].point_sheet) - pairs[*wrong].point_map).norm();
  const double usual = std::max(kClickSigma, RmsOf(fit, Without(pairs, *wrong)));
  return missed > kWrongSigmas * usual ? wrong : std::nullopt;
}

absl::Status Check(const std::vector<ControlPair>& pairs, double sheet_size) {
  if (pairs.size() < 2) return InvalidArgument("{} pairs of points, at least 2 are needed", pairs.size());
  if (pairs.size() > kMostPairs)
    return InvalidArgument("{} pairs of points, at most {} may be", pairs.size(), kMostPairs);
  double widest_map = 0;
  double widest_sheet = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!pairs[i].point_sheet.allFinite() || !pairs[i].point_map.allFinite()) {
      return InvalidArgument("pair {} has a coordinate that is not finite", i + 1);
    }
    for (std::size_t j = 0; j < i; ++j) {
      const double map = (pairs[i].point_map - pairs[j].point_map).norm();
      const double sheet = (pairs[i].point_sheet - pairs[j].point_sheet).norm();
      if (map == 0 || sheet == 0) return InvalidArgument("pairs {} and {} show the same point", j + 1, i + 1);
      widest_map = std::max(widest_map, map);
      widest_sheet = std::max(widest_sheet, sheet);
    }
  }
  if (widest_map < kLeastBaseline || widest_sheet < kLeastShare * sheet_size) {
    return InvalidArgument(
        "the pairs are at most {:.1f} m and {:.0f} units of the plan apart; {} m and {:.0f} units are needed",
        widest_map, widest_sheet, kLeastBaseline, kLeastShare * sheet_size);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PairFit> FitPairs(const std::vector<ControlPair>& pairs, double sheet_size, TransformModel widest) {
  if (absl::Status status = Check(pairs, sheet_size); !status.ok()) return status;
  PairFit result;
  result.wrong = FindWrong(pairs, widest);
  const std::vector<ControlPair> right = result.wrong ? Without(pairs, *result.wrong) : pairs;
  const Fit fit = FitTo(right, widest);
  const double size = fit.transform.scale() * sheet_size;
  if (!(size <= kLargestPlan)) {
    return InvalidArgument("by the pairs the plan is {:.0f} m wide, at most {:.0f} m are possible", size, kLargestPlan);
  }
  for (const bool mirrored : {false, true}) {
    for (const double ratio : kAxisRatios) {
      const PlanTransform other = FitWithRatio(right, mirrored, ratio);
      const bool same =
          mirrored == fit.transform.mirrored() && (ratio == 1 || fit.model != TransformModel::kSimilarity);
      const double usual = std::max(kClickSigma, RmsOf(fit.transform, right));
      if (!same && RmsOf(other, right) < usual) result.others.push_back(other);
    }
  }
  result.T_map_sheet = fit.transform;
  result.model = fit.model;
  for (const ControlPair& pair : pairs) {
    result.residuals.push_back((fit.transform(pair.point_sheet) - pair.point_map).norm());
  }
  return result;
}

}  // namespace enfilade::prior
