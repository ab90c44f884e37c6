// SPDX-License-Identifier: Apache-2.0
#include "tests/rpc/rearrange_fixture.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

TEST_F(RearrangeTest, RefusesWhatCannotBe) {
  v1::CreateMapRequest request;
  request.set_parent("sites/s");
  request.set_map_id("m2");
  request.mutable_map()->set_display_name("Second part");
  ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
  EXPECT_STATUS(Merge("m", "m"), absl::StatusCode::kInvalidArgument, HasSubstr("with itself"));
  EXPECT_STATUS(Merge("m", "none"), absl::StatusCode::kNotFound, HasSubstr("none"));
  EXPECT_STATUS(Merge(), absl::StatusCode::kFailedPrecondition, HasSubstr("no link points lead"));
  Link("between", {1, 2, 0}, {});
  const std::string session = CreateSessionIn("sites/s/maps/m2");
  EXPECT_STATUS(Merge(), absl::StatusCode::kFailedPrecondition, HasSubstr("still recording or being mapped"));
  v1::SplitMapRequest split;
  split.set_name("sites/s/maps/m2");
  EXPECT_STATUS(Call(&v1::MapService::Stub::SplitMap, split), absl::StatusCode::kFailedPrecondition,
                HasSubstr("no session leaves"));
  split.add_sessions("sites/s/sessions/none");
  EXPECT_STATUS(Call(&v1::MapService::Stub::SplitMap, split), absl::StatusCode::kNotFound, HasSubstr("none"));
  split.set_sessions(0, "sites/other/sessions/none");
  EXPECT_STATUS(Call(&v1::MapService::Stub::SplitMap, split), absl::StatusCode::kInvalidArgument, HasSubstr("site"));
  EXPECT_STATUS(Undo("sites/s/rearrangements/none"), absl::StatusCode::kNotFound, HasSubstr("rearrangements/none"));
  ASSERT_OK(FinishSession(session, 0));
  AwaitState(session, v1::Session::STATE_MAPPED);
  ASSERT_OK_AND_ASSIGN(const v1::MergeMapsResponse merged, Merge());  // without anything mapped
  EXPECT_EQ(GetSession(session).map(), "sites/s/maps/m");
  EXPECT_STATUS(Merge(), absl::StatusCode::kFailedPrecondition, HasSubstr("was merged into"));
  ASSERT_OK(Undo(merged.rearrangement().name()));
  EXPECT_EQ(GetSession(session).map(), "sites/s/maps/m2");
  EXPECT_STATUS(Undo(merged.rearrangement().name()), absl::StatusCode::kFailedPrecondition, HasSubstr("already"));

  ASSERT_OK_AND_ASSIGN(const v1::MergeMapsResponse again, Merge());
  v1::DeleteSessionRequest edit;
  edit.set_name(session);
  ASSERT_OK(Call(&v1::SessionService::Stub::DeleteSession, edit));
  EXPECT_STATUS(Undo(again.rearrangement().name()), absl::StatusCode::kFailedPrecondition,
                HasSubstr(IdOf(session).value()));
  EXPECT_EQ(GetMap("m2").name(), "sites/s/maps/m") << "nothing is undone";
  request.set_map_id("above");
  request.mutable_map()->set_display_name("Above");
  request.mutable_map()->set_level(1);
  ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
  EXPECT_STATUS(Merge("m", "above"), absl::StatusCode::kInvalidArgument, HasSubstr("level"));
  EXPECT_EQ(CountRearrangedVersions(), 3) << "two merges and an undo; nothing of what was refused";
}

TEST_F(RearrangeTest, WhatIsTooOldStaysInTheListAndCannotBeUndone) {
  server::ServerOptions options = Options();
  options.retention.undo_s = 0.0;
  options.retention.interval_s = 0.1;
  Restart(options);
  v1::CreateMapRequest request;
  request.set_parent("sites/s");
  request.set_map_id("m2");
  request.mutable_map()->set_display_name("Second part");
  ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
  Link("between", {1, 2, 0}, {});
  ASSERT_OK_AND_ASSIGN(const v1::MergeMapsResponse merged, Merge());
  v1::ListRearrangementsRequest list;
  list.set_parent("sites/s");
  EXPECT_TRUE(Eventually([&] {
    const auto listed = Call(&v1::MapService::Stub::ListRearrangements, list);
    return listed.ok() && listed->rearrangements_size() == 1 && listed->rearrangements(0).undo_expired();
  }));
  EXPECT_STATUS(Undo(merged.rearrangement().name()), absl::StatusCode::kFailedPrecondition,
                HasSubstr("can no longer be undone"));
  EXPECT_EQ(GetMap("m2").name(), "sites/s/maps/m");
}

}  // namespace
}  // namespace enfilade::testing
