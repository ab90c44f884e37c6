// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/door_action.h"
#include "core/closure/door_knowledge.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/judging_lease.h"
#include "server/app/closure/seen_grounds.h"
#include "server/app/closure/session_scene.h"
#include "server/app/graph/site_graph.h"

namespace enfilade::server {

// A door report that is to be judged.
struct ReportToJudge {
  const storage::Session& session;
  const storage::StoredDoorReport& stored;
  // Candidates that the database refused to promote: a link point joins the maps at that place already.
  const std::set<LinkPointId>& redundant;
  double waited = 0.0;  // s, since it was first too early for a verdict
};

// What is to be done about a report, and what it was judged from.
struct JudgedReport {
  SessionId session;
  std::int64_t sequence = 0;               // of the report
  std::shared_ptr<const SiteGraph> graph;  // that `knowledge` points into
  closure::DoorKnowledge knowledge;
  closure::DoorJudgement judgement;
  std::optional<SessionScene> scene;           // unset: the report could not be judged
  std::optional<Pose2> T_odom_robot;           // when a passage was reported
  std::vector<std::int64_t> compared_records;  // of the session, by sequence
};

// Judges a report by one version of the site's graph: closure::Decide decides, EvidenceGatherer gathers what it asks
// for. A report that cannot be judged has a judgement that says so; errors are the stores' and the lease's.
absl::StatusOr<JudgedReport> JudgeReport(const DoorClosureStores& stores, const JudgingLease& lease,
                                         const closure::DoorClosureOptions& options, SeenGrounds& grounds,
                                         std::shared_ptr<const SiteGraph> graph, const ReportToJudge& report);

}  // namespace enfilade::server
