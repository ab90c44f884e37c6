// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/prior/alignment/agreement.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/correction/displacement_field.h"
#include "core/prior/correction/plan_displacement.h"
#include "core/prior/correction/wall_line.h"
#include "core/prior/correction/wall_sight.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

struct CorrectedCorner {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();       // m, the map's frame
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // m^2
};

struct CorrectedWall : WallSight {
  double stretch = 1;  // its length by that of the plan as a whole
};

// Where a point of the sheet lies, by the corrected plan.
struct CorrectedPoint {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();  // m, the map's frame
  double sigma = 0;                                 // m, in the direction in which it is known least
  Sight sight = Sight::kUnseen;                     // of the wall that it is on, or else of the place
};

// How what is seen of a plan moves the rest of it.
enum class Correction {
  kNone,         // not at all: the plan stays as it was placed
  kField,        // DisplacementField
  kWallSprings,  // WallSprings
};

// A plan whose walls have been moved onto those of a map. What no robot has seen follows what was seen nearby, and far
// away the distortion of the whole. Immutable.
class CorrectedPlan {
 public:
  // Rounds of associating walls of the map with those of the plan, within a gate that narrows, and of fitting the
  // displacements robustly. `T_map_sheet`: where the plan lies as a whole. `evidence` outlives the corrected plan.
  CorrectedPlan(const PlanGraph& plan, const MapEvidence& evidence, const PlanTransform& T_map_sheet,
                Correction correction = Correction::kField);

  const std::vector<CorrectedCorner>& corners() const { return corners_; }
  const std::vector<CorrectedWall>& walls() const { return walls_; }
  // The walls' faces in the map's frame.
  const std::vector<WallFace>& faces() const { return faces_; }
  const Agreement& agreement() const { return agreement_; }
  double scale() const { return T_map_sheet_.scale(); }  // m per unit of the sheet, of the plan as a whole
  double corner_sigma() const {
    return model_.corner;
  }  // m: how far each corner is off by itself, by all that was seen
  // Of a plan that is corrected by a DisplacementField: how much likelier the map is, if the plan lies there, than if
  // it has nothing to do with the map; nats. Each metre of a wall that was seen tells by its offset, by how much the
  // plan has to be bent for it; each metre in free ground belongs to one of the ten walls in a hundred that plans
  // invent.
  double log_evidence() const { return log_evidence_; }
  CorrectedPoint Locate(const Eigen::Vector2d& point_sheet) const;

 private:
  PlanPlace PlaceOf(const Eigen::Vector2d& point_sheet) const;
  std::vector<WallFace> MovedFaces(const PlanDisplacement& field) const;
  void Correct(Correction correction);
  std::unique_ptr<const PlanDisplacement> FieldOf(Correction correction, const std::vector<PlanOffset>& offsets,
                                                  const std::vector<double>& weights) const;
  std::vector<PlanOffset> Associate(const PlanDisplacement& field, double gate) const;
  void AddOffsets(const WallFace& placed, const WallFace& moved, const std::vector<WallSample>& seen,
                  const WallLine& line, std::vector<PlanOffset>& offsets) const;
  double EvidenceOfOffsets(const std::vector<PlanOffset>& offsets, const std::vector<double>& weights) const;
  void Describe();
  double ContradictedLength() const;  // m, of walls

  const PlanGraph plan_;
  const MapEvidence& evidence_;
  PlanTransform T_map_sheet_;
  std::vector<WallFace> sheet_faces_;
  std::unique_ptr<const FaceIndex> placed_;  // the walls' centre lines, not corrected
  std::unique_ptr<const PlanDisplacement> field_;
  FieldModel model_;
  std::vector<CorrectedCorner> corners_;
  std::vector<CorrectedWall> walls_;
  std::vector<WallFace> faces_;
  Agreement agreement_;
  double log_evidence_ = 0;
};

// CorrectedPlan::log_evidence of a plan that is corrected by a DisplacementField.
double LogEvidenceOf(const PlanGraph& plan, const MapEvidence& evidence, const PlanTransform& T_map_sheet);

}  // namespace enfilade::prior
