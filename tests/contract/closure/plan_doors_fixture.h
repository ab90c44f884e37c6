// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/campus_yaml.h"
#include "client/simulator/plan/campus_plan.h"
#include "client/simulator/plan/deformed_plan.h"
#include "core/prior/formats/geojson_plan.h"
#include "server/app/closure/plan_door_joiner.h"
#include "server/app/priors/prior_alignment.h"
#include "storage/postgres/rearrange/rearrangement_store.h"
#include "tests/contract/closure/door_closures_fixture.h"

namespace enfilade::testing {

// Robots "west" and "east" map their halves of a building, each from a map of its own on; a plan of the building.
class PlanDoorsFixture : public DoorClosuresTest {
 protected:
  // `campus`: the text of a campus file, as of DriveThroughDoors.
  void MapBothHalves(const std::string& campus) {
    world_ = std::make_shared<const simulator::World>(*simulator::ParseCampus(campus));
    EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, east_, "East"), ""));
    for (const auto& [robot, map] : {std::pair("west", map_), std::pair("east", east_)}) {
      DoorDriveOptions options;
      options.campus = campus;
      options.robot = robot;
      std::vector<SessionId> sessions;
      for (const DrivenSession& driven : DriveThroughDoors(options)) {
        if (driven.log.empty()) continue;
        sessions.push_back(sessions.empty() ? Send(driven, map, {}) : Send(driven, {}, sessions.back()));
      }
      const auto truth = simulator::SimulateDrive(world_, robot, options.simulation);
      ASSERT_OK(truth);
      for (const SessionId& session : sessions) truth_[session] = truth->truth.poses;
    }
    AwaitMapped(Sessions());
  }
  std::vector<SessionId> Sessions() const {
    std::vector<SessionId> sessions;
    for (const auto& [session, truth] : truth_) sessions.push_back(session);
    return sessions;
  }
  // T_campus_place, by the truth at that keyframe of the map that is nearest to it.
  Pose2 InCampus(const graph::Anchor& anchor) {
    double least = std::numeric_limits<double>::infinity();
    Pose2 T_campus_place;
    for (const auto& [session, truth] : truth_) {
      if (MapOf(session) != anchor.map) continue;
      const auto keyframes = mapping_.ListKeyframes(Soon(), site_, session);
      EXPECT_OK(keyframes);
      for (const slam::SlamNode& node : *keyframes) {
        const Pose2 T_node_place = Between(node.T_map_node, anchor.T_map_place);
        const auto then = std::find_if(truth.begin(), truth.end(),
                                       [&](const simulator::TruePose& pose) { return pose.time >= node.time; });
        if (then == truth.end() || T_node_place.translation().norm() >= least) continue;
        least = T_node_place.translation().norm();
        T_campus_place = then->T_campus_robot * T_node_place;
      }
    }
    return T_campus_place;
  }

  void ImportPlan(const simulator::PlanDeformation& deformation) {
    const simulator::Campus& campus = world_->campus();
    const prior::PlanGraph drawn =
        simulator::Deform(simulator::PlanOf(campus, campus.levels.begin()->first), deformation).graph;
    storage::PriorMap plan;
    plan.site = site_;
    plan.id = plan_;
    plan.display_name = "Plan";
    plan.file_name = "plan.geojson";
    const std::string text = prior::WriteGeoJsonPlan(drawn);
    ASSERT_OK(prior_maps_
                  .Create(Soon(), plan,
                          {{storage::PriorMapProduct::kSheet, "plan.geojson", text},
                           {storage::PriorMapProduct::kPlan, "plan.geojson", text}})
                  .status());
  }
  // What became of it. Put to use if it was accepted.
  storage::PriorMapOutcome Activate() {
    const auto plan = prior_maps_.Get(Soon(), site_, plan_);
    EXPECT_OK(plan);
    const server::PriorAlignment alignment(prior_maps_, joins_, maps_, revisions_, blobs_, workers_->graphs());
    const auto aligned = alignment.Align(storage::CallContext::WithTimeout(std::chrono::minutes(5)), *plan, {},
                                         /*from_last=*/false, /*activate=*/true);
    EXPECT_OK(aligned);
    EXPECT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, plan->etag, aligned->outcome).status());
    AwaitSolved();
    return aligned->outcome;
  }
  void Suspend() {
    ASSERT_OK(
        prior_maps_
            .SetOutcome(Soon(), site_, plan_, 0, {.state = storage::PriorMapState::kSuspended, .reason = "by a person"})
            .status());
    AwaitSolved();
  }
  // Until the optimiser has nothing more to do.
  void AwaitSolved() {
    std::int64_t version = -1;
    for (int quiet = 0; quiet < 20;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      const std::int64_t now = Graph()->graph().version();
      quiet = now == version ? quiet + 1 : 0;
      version = now;
    }
  }
  std::shared_ptr<const server::SiteGraph> Graph() {
    workers_->graphs().MarkChanged(site_);
    return *workers_->graphs().Get(Soon(), site_);
  }
  // How many link points it has made or taken back.
  std::int64_t Join() {
    if (!joiner_) {
      joiner_.emplace(options_,
                      server::PlanDoorJoiner::Stores{
                          {sessions_, records_, mapping_, blobs_, features_, maps_, link_points_, verdicts_, leases_},
                          prior_maps_,
                          joins_},
                      workers_->graphs(), rearranger_);
    }
    const auto done = joiner_->Run(storage::CallContext::WithTimeout(std::chrono::minutes(1)));
    EXPECT_OK(done);
    AwaitSolved();
    return done.value_or(-1);
  }

  const MapId east_{"east"};
  const PriorMapId plan_{"plan"};
  std::shared_ptr<const simulator::World> world_;
  std::map<SessionId, std::vector<simulator::TruePose>> truth_;  // of the session's whole drive
  const storage::PriorMapStore prior_maps_{*pool_};
  const storage::PlanJoinStore joins_{*pool_};
  const storage::FeatureStore features_{*pool_};
  const storage::postgres::SiteLeaseStore leases_{*pool_, storage::SiteRight::kChange};
  const storage::postgres::RearrangementStore rearrangements_{*pool_};
  const slam::SlamProfiles profiles_;
  server::Rearranger rearranger_{
      {sessions_, mapping_, maps_, revisions_, blobs_, rearrangements_}, profiles_, workers_->graphs()};
  std::optional<server::PlanDoorJoiner> joiner_;
};

}  // namespace enfilade::testing
