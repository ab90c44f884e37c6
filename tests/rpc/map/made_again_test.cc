// SPDX-License-Identifier: Apache-2.0
// Drafts and maps that are made again under the names of deleted ones.
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "tests/rpc/map/map_edit_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::SizeIs;

class MadeAgainTest : public MapEditFixture {};

TEST_F(MadeAgainTest, ADraftHasNothingOfTheDeletedOne) {
  ImportRoom();
  const std::string draft = CreateDraft("d");
  ASSERT_OK(Append(draft, {Brush("a", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  v1::DeleteMapDraftRequest request;
  request.set_name(draft);
  ASSERT_OK(Call(&v1::MapEditService::Stub::DeleteMapDraft, request));
  ASSERT_EQ(CreateDraft("d"), draft);
  ASSERT_OK_AND_ASSIGN(const auto appended, Append(draft, {Brush("b", v1::MapEdit::VALUE_OCCUPIED, {{30, 10}}, 1.0)}));
  ASSERT_THAT(appended.edits(), SizeIs(1));
  ASSERT_OK(Publish(draft, "another"));
  EXPECT_TRUE(IsOccupied(30, 10));
  EXPECT_FALSE(IsOccupied(10, 10));
}

TEST_F(MadeAgainTest, AMapHasNothingOfTheDeletedOne) {
  ImportRoom();
  ASSERT_OK(Append(CreateDraft("d"), {Brush("a", v1::MapEdit::VALUE_OCCUPIED, {{10, 10}}, 1.0)}));
  v1::DeleteMapRequest deleted;
  deleted.set_name("sites/s/maps/m");
  deleted.set_force(true);
  ASSERT_OK(Call(&v1::MapService::Stub::DeleteMap, deleted));
  v1::CreateMapRequest created;
  created.set_parent("sites/s");
  created.set_map_id("m");
  created.mutable_map()->set_display_name("Again");
  created.mutable_map()->set_environment(v1::Map::ENVIRONMENT_INDOOR);
  ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, created));
  ImportRoom(/*keep_edits=*/false, "2, 3");  // its revision 1, too
  v1::GetMapDraftRequest request;
  request.set_name(CreateDraft("d"));
  ASSERT_OK_AND_ASSIGN(const auto found, Call(&v1::MapEditService::Stub::GetMapDraft, request));
  EXPECT_EQ(found.draft().lattice().pose_map_lattice().x(), 2.0);
  EXPECT_EQ(found.draft().lattice().pose_map_lattice().y(), 3.0);
  ASSERT_OK(Append(request.name(), {Brush("b", v1::MapEdit::VALUE_OCCUPIED, {{30, 10}}, 1.0)}));
  ASSERT_OK(Publish(request.name(), "another"));
  EXPECT_TRUE(IsOccupied(30, 10));
  EXPECT_FALSE(IsOccupied(10, 10));
}

}  // namespace
}  // namespace enfilade::testing
