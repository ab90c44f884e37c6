// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/closure/decide.h"
#include "core/closure/door_knowledge.h"
#include "core/closure/graph_search.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/judging_lease.h"
#include "server/app/closure/place_comparer.h"
#include "server/app/closure/seen_grounds.h"
#include "server/app/closure/session_scene.h"
#include "server/app/closure/stored_views.h"

namespace enfilade::server {

// Gathers the evidence that closure::Decide asks for, from the graph, the stores and perception. The lease is renewed
// before each comparison. Writes nothing but the features of kept images. For one passage.
class EvidenceGatherer {
 public:
  // All must outlive it; `knowledge` is the value that it adds to.
  EvidenceGatherer(const DoorClosureStores& stores, const JudgingLease& lease, const SessionScene& scene,
                   SeenGrounds& grounds, closure::DoorKnowledge& knowledge);

  // Reads what the robot saw behind the door; before the first step. Errors of both are the stores' and the lease's.
  absl::Status ReadRobotViews();
  // Adds what the step asks for to the knowledge. The step must not be a judgement.
  absl::Status Gather(const closure::DoorStep& step);

  // The robot's records that were used, by sequence.
  const std::vector<std::int64_t>& used_records() const { return used_records_; }
  // What could not be read and why, as text; empty if everything could.
  std::string Faults() const { return views_.Faults(); }

 private:
  absl::Status Gather(const closure::CompareImages& step);
  absl::Status Gather(const closure::CompareClouds& step);
  absl::Status Gather(const closure::MatchScans& step);
  absl::Status ReadRobotImages();
  absl::Status ReadRobotCloud();
  // The evidence of the place's anchor, of what was read last.
  std::vector<storage::Evidence> FindKept(const closure::ComparedPlace& place) const;

  const DoorClosureStores& stores_;
  const JudgingLease& lease_;
  const SessionScene& scene_;
  SeenGrounds& grounds_;
  closure::DoorKnowledge& knowledge_;
  closure::GraphSearch graph_search_;
  StoredViews views_;
  RobotViews robot_;
  PlaceComparer comparer_;
  std::vector<storage::Evidence> kept_;  // of the places whose images were compared last
  std::vector<std::int64_t> used_records_;
};

}  // namespace enfilade::server
