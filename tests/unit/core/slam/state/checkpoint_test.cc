// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "core/compression/compression.h"
#include "core/slam/submaps/robot_rays.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/chain_of_submaps.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using ::testing::HasSubstr;

// A state with a value in every field, and the rows that belong to it.
MapperState FullState() {
  MapperState state = testing::MakeSubmapChain({.submaps = 3});
  for (auto& [id, submap] : state.finished) {
    submap.content = Encode({submap.nodes, submap.next, {}, SubmapGrid(0.05, {})});
  }
  state.loop_closures[0] = testing::MakeLoopClosure(0, 0, 2, {0.1, 0.2, 0.3});
  JoinAll(state);
  SubmapContent content{{}, {}, {}, SubmapGrid(0.05, {})};
  const auto walls = testing::WallsFromText({"####", "#  #", "####"}, 1.0);
  const grid::ScanRays rays = RobotRays(testing::Scan(walls, {1.5, 1.5, 0.0}, {.beams = 90}, 0, 1), {});
  EXPECT_OK(content.grid.Insert({1.5, 1.5, 0.0}, rays));
  content.nodes = {{3, false, 0.5, {1.5, 1.5, 0.0}, 2.0 * Eigen::Matrix3d::Identity()}};
  content.scans = {rays};
  state.active = Submap{3, 17, {30.0, 0.5, -0.2}, std::move(content)};
  SlamNode node;
  node.id = 3;
  node.submap = 3;
  state.nodes[3] = node;
  state.entry = ExistingMapEntry{{{1.0, 2.0, 0.5}, 0.5 * Eigen::Matrix3d::Identity()}, Pose2{9.0, 8.0, 0.7}};
  state.track = Track{{1.7, 1.6, 0.1}, Pose2{4.0, 4.0, 0.4}, 5'000, 4'000, Step{{0.2, 0.1, 0.05}, 0.25}, 1.25, {2, 1}};
  state.ended = true;
  state.nodes_at_solve = 2;
  state.unsolved_closures = true;
  state.urgent_closures = true;
  state.adrift_since = 2;
  return state;
}

SlamMap RowsOf(const MapperState& state) {
  SlamMap map;
  map.nodes = state.nodes;
  map.loop_closures = state.loop_closures;
  for (const auto& [id, submap] : state.finished) {
    map.submaps[id] = {id, submap.version, submap.T_map_submap, true, submap.content};
  }
  if (state.active) {
    map.submaps[state.active->id] = {state.active->id, state.active->version, state.active->T_map_submap, false, ""};
  }
  return map;
}

void ExpectEqualTracks(const std::optional<Track>& a, const std::optional<Track>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (!a) return;
  EXPECT_EQ(a->T_submap_robot, b->T_submap_robot);
  EXPECT_EQ(a->T_odom_robot, b->T_odom_robot);
  EXPECT_EQ(a->time, b->time);
  EXPECT_EQ(a->matched_at, b->matched_at);
  EXPECT_EQ(a->last_step, b->last_step);
  EXPECT_EQ(a->length_since_keyframe, b->length_since_keyframe);
  EXPECT_EQ(a->quality, b->quality);
}

struct StateChange {
  const char* name;
  std::function<void(MapperState&)> apply;
};

// Each field by itself unset or changed.
class CheckpointTest : public ::testing::TestWithParam<StateChange> {
 protected:
  CheckpointTest() : state_(FullState()) { GetParam().apply(state_); }

  MapperState state_;
};

TEST_P(CheckpointTest, RestoresTheState) {
  ASSERT_OK_AND_ASSIGN(const MapperState restored, DecodeCheckpoint(EncodeCheckpoint(state_), RowsOf(state_), {}));
  ExpectEqualTracks(restored.track, state_.track);
  ASSERT_EQ(restored.entry.has_value(), state_.entry.has_value());
  if (state_.entry) {
    EXPECT_EQ(restored.entry->T_map_robot.pose, state_.entry->T_map_robot.pose);
    EXPECT_EQ(restored.entry->T_map_robot.covariance, state_.entry->T_map_robot.covariance);
    EXPECT_EQ(restored.entry->T_odom_robot, state_.entry->T_odom_robot);
  }
  ASSERT_EQ(restored.active.has_value(), state_.active.has_value());
  if (state_.active) {
    EXPECT_EQ(restored.active->T_map_submap, state_.active->T_map_submap) << "from the row";
    EXPECT_EQ(restored.active->version, state_.active->version);
    EXPECT_EQ(restored.active->content.nodes, state_.active->content.nodes);
    EXPECT_TRUE(restored.active->content.grid == state_.active->content.grid);
  }
  EXPECT_EQ(restored.ended, state_.ended);
  EXPECT_EQ(restored.nodes_at_solve, state_.nodes_at_solve);
  EXPECT_EQ(restored.unsolved_closures, state_.unsolved_closures);
  EXPECT_EQ(restored.urgent_closures, state_.urgent_closures);
  EXPECT_EQ(restored.adrift_since, state_.adrift_since);
  EXPECT_EQ(restored.nodes, state_.nodes);
  EXPECT_EQ(restored.loop_closures, state_.loop_closures);
  EXPECT_EQ(restored.joined, state_.joined) << "follows from the loop closures";
  EXPECT_EQ(restored.finished.size(), state_.finished.size());
  for (const auto& [id, submap] : state_.finished) EXPECT_EQ(restored.finished.at(id).nodes, submap.nodes);
}

TEST_P(CheckpointTest, IsTheSameTakenAgainAfterRestore) {
  const std::string checkpoint = EncodeCheckpoint(state_);
  ASSERT_OK_AND_ASSIGN(const MapperState restored, DecodeCheckpoint(checkpoint, RowsOf(state_), {}));
  EXPECT_EQ(EncodeCheckpoint(restored), checkpoint);
}

INSTANTIATE_TEST_SUITE_P(
    States, CheckpointTest,
    ::testing::Values(StateChange{"Full", [](MapperState&) {}},
                      StateChange{"NoEntry", [](MapperState& s) { s.entry.reset(); }},
                      StateChange{"EntryWithoutOdometry", [](MapperState& s) { s.entry->T_odom_robot.reset(); }},
                      StateChange{"NoTrack", [](MapperState& s) { s.track.reset(); }},
                      StateChange{"TrackWithoutOdometry", [](MapperState& s) { s.track->T_odom_robot.reset(); }},
                      StateChange{"TrackWithoutStep", [](MapperState& s) { s.track->last_step.reset(); }},
                      StateChange{"NotEnded", [](MapperState& s) { s.ended = false; }},
                      StateChange{"NothingUnsolved", [](MapperState& s) { s.unsolved_closures = false; }},
                      StateChange{"NothingUrgent", [](MapperState& s) { s.urgent_closures = false; }},
                      StateChange{"NotAdrift", [](MapperState& s) { s.adrift_since.reset(); }},
                      StateChange{"AdriftFromTheFirst", [](MapperState& s) { s.adrift_since = 0; }},
                      StateChange{"RejectedClosure",
                                  [](MapperState& s) {
                                    s.loop_closures.at(0).state = LoopClosureState::kRejected;
                                    JoinAll(s);
                                  }},
                      StateChange{"Fresh", [](MapperState& s) { s = {}; }}),
    [](const ::testing::TestParamInfo<StateChange>& change) { return std::string(change.param.name); });

struct BadRows {
  const char* name;
  std::function<void(SlamMap&)> spoil;
  const char* message;
};

class CheckpointRefuses : public ::testing::TestWithParam<BadRows> {};

TEST_P(CheckpointRefuses, RowsThatItDoesNotBelongTo) {
  const MapperState state = FullState();
  SlamMap rows = RowsOf(state);
  ASSERT_OK(DecodeCheckpoint(EncodeCheckpoint(state), rows, {}));
  GetParam().spoil(rows);
  EXPECT_STATUS(DecodeCheckpoint(EncodeCheckpoint(state), rows, {}), absl::StatusCode::kDataLoss,
                HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Rows, CheckpointRefuses,
    ::testing::Values(BadRows{"NodeMissing", [](SlamMap& m) { m.nodes.erase(1); }, "4 nodes"},
                      BadRows{"NodeMore", [](SlamMap& m) { m.nodes[9].id = 9; }, "but 5"},
                      BadRows{"ClosureMissing", [](SlamMap& m) { m.loop_closures.clear(); }, "1 loop closures"},
                      BadRows{"SubmapMissing", [](SlamMap& m) { m.submaps.erase(0); }, "3 finished submaps"},
                      BadRows{"SubmapDamaged", [](SlamMap& m) { m.submaps.at(1).content = "x"; }, "stored submap 1"},
                      BadRows{"ActiveMissing", [](SlamMap& m) { m.submaps.erase(3); }, "submap 3 version 17"},
                      BadRows{"ActiveOlder", [](SlamMap& m) { m.submaps.at(3).version = 16; }, "submap 3 version 17"},
                      BadRows{"ActiveFinished", [](SlamMap& m) { m.submaps.at(3).finished = true; }, "submap 3"}),
    [](const ::testing::TestParamInfo<BadRows>& rows) { return std::string(rows.param.name); });

// The bytes of a checkpoint before compression.
std::string RawCheckpoint(const MapperState& state) {
  const auto raw = Decompress(EncodeCheckpoint(state), 1 << 20);
  EXPECT_OK(raw);
  return *raw;
}

TEST(Checkpoint, RefusesTruncatedAndTrailingBytes) {
  const MapperState state = FullState();
  const SlamMap rows = RowsOf(state);
  const std::string raw = RawCheckpoint(state);
  for (std::size_t size = 0; size < raw.size(); size += 1 + size / 30) {
    EXPECT_CODE(DecodeCheckpoint(Compress(raw.substr(0, size)), rows, {}), absl::StatusCode::kDataLoss) << size;
  }
  EXPECT_CODE(DecodeCheckpoint(Compress(raw + '\0'), rows, {}), absl::StatusCode::kDataLoss);
}

TEST(Checkpoint, RefusesAnotherVersion) {
  const MapperState state = FullState();
  std::string raw = RawCheckpoint(state);
  raw[0] = 7;
  EXPECT_STATUS(DecodeCheckpoint(Compress(raw), RowsOf(state), {}), absl::StatusCode::kDataLoss,
                HasSubstr("version 7"));
}

TEST(Checkpoint, KeepsWhatWasSeenAtTheEntry) {
  MapperState state = FullState();
  ASSERT_EQ(RawCheckpoint(state)[0], 5) << "without it, older programs can read the checkpoint";
  state.entry->seen = state.active->content.scans.front();
  ASSERT_OK_AND_ASSIGN(const MapperState restored, DecodeCheckpoint(EncodeCheckpoint(state), RowsOf(state), {}));
  ASSERT_TRUE(restored.entry && restored.entry->seen);
  EXPECT_EQ(restored.entry->seen->hits, state.entry->seen->hits);
  EXPECT_EQ(restored.entry->seen->free_ends, state.entry->seen->free_ends);
  EXPECT_EQ(restored.entry->seen->origin, state.entry->seen->origin);
  EXPECT_EQ(restored.entry->T_odom_robot, state.entry->T_odom_robot);
  ExpectEqualTracks(restored.track, state.track);
}

constexpr std::size_t kBeforeErrors = 1 + 3 * 8 + 1 + 8 + 1 + 1 + 8;
constexpr std::size_t kErrorsBytes = 4 * 8;

// Version 4 had no statistics of errors, between the flags and the entry.
TEST(Checkpoint, ReadsTheVersionBeforeErrorStatistics) {
  const MapperState state = FullState();
  std::string raw = RawCheckpoint(state);
  raw.erase(kBeforeErrors, kErrorsBytes);
  raw[0] = 4;
  ASSERT_OK_AND_ASSIGN(const MapperState restored, DecodeCheckpoint(Compress(raw), RowsOf(state), {}));
  EXPECT_EQ(restored.errors, ErrorStatistics{});
  EXPECT_EQ(restored.entry.has_value(), state.entry.has_value());
  ExpectEqualTracks(restored.track, state.track);
}

// Version 3 had no entry, either: a byte fewer if there is none.
TEST(Checkpoint, ReadsTheVersionBeforeEntries) {
  MapperState state = FullState();
  state.entry.reset();
  std::string raw = RawCheckpoint(state);
  ASSERT_EQ(raw[kBeforeErrors + kErrorsBytes], 0) << "no entry";
  raw.erase(kBeforeErrors, kErrorsBytes + 1);
  raw[0] = 3;
  ASSERT_OK_AND_ASSIGN(const MapperState restored, DecodeCheckpoint(Compress(raw), RowsOf(state), {}));
  EXPECT_FALSE(restored.entry.has_value());
  ExpectEqualTracks(restored.track, state.track);
  EXPECT_EQ(restored.adrift_since, state.adrift_since);
}

}  // namespace
}  // namespace enfilade::slam
