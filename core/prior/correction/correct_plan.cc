// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/correct_plan.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/prior/correction/wall_line.h"
#include "core/prior/correction/wall_springs.h"

namespace enfilade::prior {
namespace {

constexpr double kLeastStraight = 0.6;  // less straight walls of the map are furniture, more likely than not
constexpr double kPiece = 1.0;          // m of a wall that are observed as one
constexpr double kLeastSeen = 0.4;      // of a piece
constexpr double kOffsetSigma = 0.05;   // m
constexpr std::size_t kMostOffsets = 900;
constexpr double kGates[] = {1.2, 0.8, 0.5, 0.4, 0.3};  // m
constexpr int kReweightings = 3;
constexpr double kMostSurprise = 6.0;  // chi-squared of a wall that counts fully
constexpr double kOnWall = 0.3;        // m: what is so near a wall moves with it
constexpr double kInvented = 0.1;      // of a plan's walls: buildings do not have them

std::vector<WallFace> CentreLines(const PlanGraph& plan, const PlanTransform& T_map_sheet) {
  std::vector<WallFace> lines;
  for (int i = 0; i < static_cast<int>(plan.walls.size()); ++i) {
    const PlanWall& wall = plan.walls[static_cast<std::size_t>(i)];
    lines.push_back({T_map_sheet(plan.corners[static_cast<std::size_t>(wall.from)].point),
                     T_map_sheet(plan.corners[static_cast<std::size_t>(wall.to)].point), i, Eigen::Vector2d::Zero()});
  }
  return lines;
}

// Weights of offsets by how well their walls agree with all others (dynamic covariance scaling; Agarwal et al. 2013).
std::vector<double> WeightsOf(const PlanDisplacement& field, const std::vector<int>& walls) {
  const std::vector<double> surprise = field.SurpriseOf(walls);
  std::vector<double> weights;
  for (const int wall : walls) {
    const double scale = std::min(1.0, 2 * kMostSurprise / (kMostSurprise + surprise[static_cast<std::size_t>(wall)]));
    weights.push_back(scale * scale);
  }
  return weights;
}

}  // namespace

CorrectedPlan::CorrectedPlan(const PlanGraph& plan, const MapEvidence& evidence, const PlanTransform& T_map_sheet,
                             Correction correction)
    : plan_(plan), evidence_(evidence), T_map_sheet_(T_map_sheet), sheet_faces_(FacesOf(plan)) {
  placed_ = std::make_unique<FaceIndex>(CentreLines(plan, T_map_sheet), kOnWall);
  model_.corner = 0.03;
  field_ = FieldOf(correction, {}, {});
  if (correction != Correction::kNone) Correct(correction);
  Describe();
  log_evidence_ += std::log(kInvented) * ContradictedLength();  // a metre counts as a wall, as each seen one does
}

void CorrectedPlan::Correct(Correction correction) {
  bool first = true;
  std::vector<PlanOffset> offsets;
  std::vector<double> weights;
  for (const double gate : kGates) {
    std::vector<PlanOffset> next = Associate(*field_, gate);
    if (next.empty()) break;
    offsets = std::move(next);
    weights.clear();
    std::vector<int> walls;
    std::map<std::array<int, 2>, int> known;
    for (const PlanOffset& offset : offsets) {
      walls.push_back(known.try_emplace(offset.place.corners, static_cast<int>(known.size())).first->second);
    }
    for (int i = 0; i < kReweightings; ++i) {
      if (!first && i == 1 && correction == Correction::kField) model_ = LikeliestModel(offsets, weights);
      field_ = FieldOf(correction, offsets, weights);
      if (i + 1 < kReweightings) weights = WeightsOf(*field_, walls);
    }
    first = false;
  }
  if (correction == Correction::kField && !offsets.empty()) log_evidence_ = EvidenceOfOffsets(offsets, weights);
}

// Walls that are not the plan's lie anywhere within the widest gate.
double CorrectedPlan::EvidenceOfOffsets(const std::vector<PlanOffset>& offsets,
                                        const std::vector<double>& weights) const {
  return DisplacementField(model_, offsets, weights).LogOddsToChance(-std::log(2 * kGates[0]));
}

std::unique_ptr<const PlanDisplacement> CorrectedPlan::FieldOf(Correction correction,
                                                               const std::vector<PlanOffset>& offsets,
                                                               const std::vector<double>& weights) const {
  if (correction != Correction::kWallSprings) return std::make_unique<DisplacementField>(model_, offsets, weights);
  std::vector<Eigen::Vector2d> corners;
  for (const PlanCorner& corner : plan_.corners) corners.push_back(T_map_sheet_(corner.point));
  std::vector<WallSpring> walls;
  for (const PlanWall& wall : plan_.walls) walls.push_back({wall.from, wall.to});
  return std::make_unique<WallSprings>(SpringOptions{}, std::move(corners), walls, offsets, weights);
}

std::vector<WallFace> CorrectedPlan::MovedFaces(const PlanDisplacement& field) const {
  std::vector<Eigen::Vector2d> moves(plan_.corners.size());
  for (std::size_t i = 0; i < moves.size(); ++i) {
    moves[i] = field.MeanAt({T_map_sheet_(plan_.corners[i].point), {static_cast<int>(i), -1}, {1, 0}});
  }
  std::vector<WallFace> faces = Transformed(sheet_faces_, T_map_sheet_);
  for (WallFace& face : faces) {
    const PlanWall& wall = plan_.walls[static_cast<std::size_t>(face.wall)];
    face.from += moves[static_cast<std::size_t>(wall.from)];
    face.to += moves[static_cast<std::size_t>(wall.to)];
  }
  return faces;
}

std::vector<PlanOffset> CorrectedPlan::Associate(const PlanDisplacement& field, double gate) const {
  const std::vector<WallFace> moved = MovedFaces(field);
  const std::vector<WallFace> placed = Transformed(sheet_faces_, T_map_sheet_);
  const FaceIndex index(moved, gate);
  std::vector<std::vector<WallSample>> seen(moved.size());  // of each face
  for (const WallPoint& wall : evidence_.walls) {
    if (wall.straightness < kLeastStraight) continue;
    const auto nearest = index.Nearest(wall.point, wall.along, kParallel, wall.open);
    if (!nearest) continue;
    const auto face = static_cast<std::size_t>(nearest->face);
    if (const auto sample = SampleOf(wall.point, *nearest, moved[face])) seen[face].push_back(*sample);
  }
  std::vector<PlanOffset> offsets;
  for (std::size_t first = 0, next = 0; first < moved.size(); first = next) {
    std::vector<WallSample> of_wall;
    for (next = first; next < moved.size() && moved[next].wall == moved[first].wall; ++next) {
      of_wall.insert(of_wall.end(), seen[next].begin(), seen[next].end());
    }
    if (of_wall.empty()) continue;
    WallFace centre = moved[first];
    const Eigen::Vector2d aside = 0.5 * (moved[next - 1].from - moved[first].from);
    centre.from += aside;
    centre.to += aside;
    const WallLine line = LikeliestLine(centre, of_wall, gate / 2, evidence_);
    if (!line.is_seen()) continue;
    for (std::size_t face = first; face < next; ++face) {
      AddOffsets(placed[face], moved[face], seen[face], line, offsets);
    }
  }
  return offsets;
}

// One for each piece of the face on which there is enough of what lies on the line.
void CorrectedPlan::AddOffsets(const WallFace& placed, const WallFace& moved, const std::vector<WallSample>& seen,
                               const WallLine& line, std::vector<PlanOffset>& offsets) const {
  const double piece = std::max(kPiece, evidence_.wall_length() / static_cast<double>(kMostOffsets));
  const int pieces = std::max(1, static_cast<int>(std::lround((placed.to - placed.from).norm() / piece)));
  const Eigen::Vector2d way = moved.to - moved.from;
  const Eigen::Vector2d normal = Eigen::Vector2d(-way.y(), way.x()).normalized();
  std::vector<std::vector<double>> values(static_cast<std::size_t>(pieces));  // from where the wall was placed
  for (const WallSample& sample : seen) {
    const double fraction = sample.at / way.norm();
    if (std::abs(sample.across - line.AcrossAt(fraction)) > kOnLine) continue;
    const Eigen::Vector2d before = placed.from + fraction * (placed.to - placed.from);
    const Eigen::Vector2d after = moved.from + fraction * way;
    const auto number = static_cast<std::size_t>(std::min(pieces - 1, static_cast<int>(fraction * pieces)));
    values[number].push_back(sample.across + normal.dot(after - before));
  }
  const PlanWall& wall = plan_.walls[static_cast<std::size_t>(placed.wall)];
  for (int i = 0; i < pieces; ++i) {
    std::vector<double>& of_piece = values[static_cast<std::size_t>(i)];
    const double fraction = (i + 0.5) / pieces;
    if (of_piece.size() < 2 || line.SupportedShare(fraction - 0.5 / pieces, fraction + 0.5 / pieces) < kLeastSeen)
      continue;
    offsets.push_back({.place = {.point = placed.from + fraction * (placed.to - placed.from),
                                 .corners = {wall.from, wall.to},
                                 .shares = {1 - fraction, fraction}},
                       .normal = normal,
                       .offset = Median(of_piece),
                       .sigma = kOffsetSigma});
  }
}

void CorrectedPlan::Describe() {
  for (std::size_t i = 0; i < plan_.corners.size(); ++i) {
    const Eigen::Vector2d placed = T_map_sheet_(plan_.corners[i].point);
    const Displacement moved = field_->At({placed, {static_cast<int>(i), -1}, {1, 0}});
    corners_.push_back({placed + moved.mean, moved.covariance});
  }
  faces_ = MovedFaces(*field_);
  agreement_ = Compare(FaceIndex(faces_, 1.5), evidence_);
  const std::vector<WallFace> placed = CentreLines(plan_, T_map_sheet_);
  std::vector<WallFace> lines = placed;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    lines[i].from = corners_[static_cast<std::size_t>(plan_.walls[i].from)].point;
    lines[i].to = corners_[static_cast<std::size_t>(plan_.walls[i].to)].point;
  }
  const std::vector<WallSight> sights = SightsOf(lines, faces_, evidence_);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double before = (placed[i].to - placed[i].from).norm();
    walls_.push_back({sights[i], before > 0 ? (lines[i].to - lines[i].from).norm() / before : 1.0});
  }
}

double CorrectedPlan::ContradictedLength() const {
  double length = 0;
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    const Eigen::Vector2d& from = corners_[static_cast<std::size_t>(plan_.walls[i].from)].point;
    const Eigen::Vector2d& to = corners_[static_cast<std::size_t>(plan_.walls[i].to)].point;
    length += walls_[i].contradicted_share * (to - from).norm();
  }
  return length;
}

PlanPlace CorrectedPlan::PlaceOf(const Eigen::Vector2d& point_sheet) const {
  PlanPlace place{.point = T_map_sheet_(point_sheet)};
  const auto nearest = placed_->Nearest(place.point, Eigen::Vector2d::Zero(), 0);
  if (!nearest) return place;
  const PlanWall& wall = plan_.walls[static_cast<std::size_t>(nearest->face)];
  place.corners = {wall.from, wall.to};
  place.shares = {1 - nearest->fraction, nearest->fraction};
  return place;
}

CorrectedPoint CorrectedPlan::Locate(const Eigen::Vector2d& point_sheet) const {
  const PlanPlace place = PlaceOf(point_sheet);
  const Displacement moved = field_->At(place);
  CorrectedPoint located;
  located.point = place.point + moved.mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moved.covariance, Eigen::EigenvaluesOnly);
  located.sigma = std::sqrt(std::max(0.0, axes.eigenvalues()(1)));
  located.sight = SightOf(evidence_, located.point);
  if (place.corners[0] < 0 && located.sight == Sight::kContradicted) located.sight = Sight::kSeen;  // ground, as drawn
  return located;
}

double LogEvidenceOf(const PlanGraph& plan, const MapEvidence& evidence, const PlanTransform& T_map_sheet) {
  return CorrectedPlan(plan, evidence, T_map_sheet).log_evidence();
}

}  // namespace enfilade::prior
