// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/prior_map_store.h"

#include <gmock/gmock.h>

#include "core/base/sha256.h"
#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using storage::NewPriorMapFile;
using storage::PriorMap;
using storage::PriorMapProduct;
using storage::PriorMapState;

class PriorMapStoreTest : public StoreTest {
 protected:
  absl::StatusOr<PriorMap> Create(const std::string& id, const std::string& display_name) {
    PriorMap prior_map;
    prior_map.site = site_;
    prior_map.id = PriorMapId(id);
    prior_map.display_name = display_name;
    prior_map.level = -1;
    prior_map.reason = "new";
    prior_map.file_name = "plan.png";
    prior_map.warnings = {"a \"warning\"", "another"};
    prior_map.elements = {.walls = 9, .corners = 8, .doors = 7, .rooms = 6, .shafts = 5, .metres_per_unit = 0.05};
    return prior_maps_.Create(
        Soon(), prior_map, {{PriorMapProduct::kSheet, "sheet.png", "pixels"}, {PriorMapProduct::kPlan, "plan", "{}"}});
  }
  static storage::PriorMapOutcome Accepted(std::vector<NewPriorMapFile> files) {
    storage::PriorMapOutcome outcome{.state = PriorMapState::kProposed, .reason = "it fits"};
    storage::PriorMapAlignment& alignment = outcome.alignment.emplace();
    alignment.T_world_sheet.linear << 1, 2, 3, 4;
    alignment.T_world_sheet.offset = {5, 6};
    alignment.model = prior::TransformModel::kAffine;
    alignment.explained = 0.75;
    alignment.contradicted = 0.125;
    alignment.rival_ratio = 1.5;
    alignment.maps = {MapId("hall"), MapId("lab")};
    alignment.graph_version = 7;
    alignment.pairs = {{{1, 2}, MapId("hall"), {3, 4}}, {{5, 6}, MapId(), {7, 8}}};
    alignment.tied_walls = 12;
    alignment.joined_maps = {MapId("lab")};
    outcome.files = std::move(files);
    return outcome;
  }
  std::vector<std::string> FilesOf(const PriorMapId& id) {
    std::vector<std::string> files;
    const auto stored = prior_maps_.ListFiles(Soon(), site_, id);
    EXPECT_OK(stored.status());
    if (!stored.ok()) return files;
    for (const storage::PriorMapFile& file : *stored) {
      const auto bytes = blobs_.Get(Soon(), site_, file.sha256);
      files.push_back(file.name + ": " + bytes.value_or("missing"));
      EXPECT_EQ(file.size, static_cast<std::int64_t>(bytes.value_or("").size()));
    }
    return files;
  }

  const PriorMapId plan_{"plan"};
  storage::PriorMapStore prior_maps_{*pool_};
  storage::postgres::GraphStore graphs_{*pool_};
};

TEST_F(PriorMapStoreTest, GivesBackWhatWasImported) {
  ASSERT_OK(Create("plan", "Ground floor"));
  ASSERT_OK_AND_ASSIGN(const PriorMap found, prior_maps_.Get(Soon(), site_, plan_));
  EXPECT_EQ(found.display_name, "Ground floor");
  EXPECT_EQ(found.level, -1);
  EXPECT_EQ(found.state, PriorMapState::kNew);
  EXPECT_EQ(found.file_name, "plan.png");
  EXPECT_THAT(found.warnings, ::testing::ElementsAre("a \"warning\"", "another"));
  EXPECT_EQ(found.elements.rooms, 6);
  EXPECT_EQ(found.elements.metres_per_unit, 0.05);
  EXPECT_FALSE(found.alignment.has_value());
  EXPECT_GT(found.create_time, 0);
  EXPECT_THAT(FilesOf(plan_), ::testing::ElementsAre("sheet.png: pixels", "plan: {}"));
}

TEST_F(PriorMapStoreTest, NamesWhatIsTaken) {
  ASSERT_OK(Create("plan", "Ground floor"));
  const auto same_id = Create("plan", "Other");
  EXPECT_CODE(same_id, absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(same_id.status().message(), ::testing::HasSubstr("priorMaps/plan"));
  const auto same_name = Create("other", "Ground floor");
  EXPECT_CODE(same_name, absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(same_name.status().message(), ::testing::HasSubstr("\"Ground floor\""));
  DeleteSite(site_);
  EXPECT_CODE(Create("third", "Third"), absl::StatusCode::kNotFound);
}

TEST_F(PriorMapStoreTest, ListsById) {
  for (const char* id : {"c", "a", "b"}) ASSERT_OK(Create(id, id));
  ASSERT_OK_AND_ASSIGN(const auto first, prior_maps_.List(Soon(), site_, {.limit = 2, .after = ""}));
  ASSERT_EQ(first.size(), 2U);
  EXPECT_EQ(first[0].id.value(), "a");
  ASSERT_OK_AND_ASSIGN(const auto rest, prior_maps_.List(Soon(), site_, {.limit = 2, .after = "b"}));
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_EQ(rest[0].id.value(), "c");
}

TEST_F(PriorMapStoreTest, AnAlignmentReplacesTheOneBefore) {
  ASSERT_OK(Create("plan", "Ground floor"));
  ASSERT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, 0,
                                   Accepted({{PriorMapProduct::kCorrected, "walls", "old"},
                                             {PriorMapProduct::kPicture, "fit.png", "old picture"}})));
  ASSERT_OK_AND_ASSIGN(
      const PriorMap set,
      prior_maps_.SetOutcome(Soon(), site_, plan_, 0, Accepted({{PriorMapProduct::kCorrected, "walls", "new"}})));
  EXPECT_EQ(set.state, PriorMapState::kProposed);
  EXPECT_EQ(set.reason, "it fits");
  ASSERT_OK_AND_ASSIGN(const PriorMap found, prior_maps_.Get(Soon(), site_, plan_));
  ASSERT_TRUE(found.alignment.has_value());
  EXPECT_EQ(found.alignment->T_world_sheet.linear, Accepted({}).alignment->T_world_sheet.linear);
  EXPECT_EQ(found.alignment->T_world_sheet.offset, Eigen::Vector2d(5, 6));
  EXPECT_EQ(found.alignment->model, prior::TransformModel::kAffine);
  EXPECT_EQ(found.alignment->explained, 0.75);
  EXPECT_EQ(found.alignment->contradicted, 0.125);
  EXPECT_EQ(found.alignment->rival_ratio, 1.5);
  EXPECT_EQ(found.alignment->maps, Accepted({}).alignment->maps);
  EXPECT_EQ(found.alignment->graph_version, 7);
  EXPECT_EQ(found.alignment->tied_walls, 12);
  EXPECT_EQ(found.alignment->joined_maps, Accepted({}).alignment->joined_maps);
  ASSERT_EQ(found.alignment->pairs.size(), 2U);
  EXPECT_EQ(found.alignment->pairs[0].map, MapId("hall"));
  EXPECT_EQ(found.alignment->pairs[1].point_map, Eigen::Vector2d(7, 8));
  EXPECT_GT(found.alignment->time, 0);
  EXPECT_THAT(FilesOf(plan_), ::testing::ElementsAre("sheet.png: pixels", "plan: {}", "walls: new"));
}

TEST_F(PriorMapStoreTest, ARefusedAlignmentKeepsTheLastOne) {
  ASSERT_OK(Create("plan", "Ground floor"));
  ASSERT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, Accepted({{PriorMapProduct::kCorrected, "walls", "old"}})));
  ASSERT_OK_AND_ASSIGN(const PriorMap refused,
                       prior_maps_.SetOutcome(Soon(), site_, plan_, 0, {PriorMapState::kDiverged, "nothing fits"}));
  EXPECT_EQ(refused.state, PriorMapState::kDiverged);
  EXPECT_EQ(refused.reason, "nothing fits");
  EXPECT_TRUE(refused.alignment.has_value());
  EXPECT_EQ(FilesOf(plan_).size(), 3U);
}

TEST_F(PriorMapStoreTest, OneInUseIsPartOfTheGraph) {
  ASSERT_OK(Create("plan", "Ground floor"));
  ASSERT_OK_AND_ASSIGN(const std::int64_t first, graphs_.GetVersion(Soon(), site_));
  ASSERT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, Accepted({{PriorMapProduct::kTies, "ties", "bytes"}})));
  EXPECT_EQ(*graphs_.GetVersion(Soon(), site_), first) << "it is proposed only";
  EXPECT_THAT(*graphs_.ReadPlanTies(Soon(), site_, {}), ::testing::IsEmpty());

  ASSERT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, {PriorMapState::kActive, "right"}));
  EXPECT_EQ(*graphs_.GetVersion(Soon(), site_), first + 1);
  ASSERT_OK_AND_ASSIGN(const auto versions, graphs_.ListVersions(Soon(), site_, 0, 1));
  EXPECT_EQ(versions.at(0).cause, storage::GraphCause::kPriorMapChanged);
  EXPECT_EQ(versions.at(0).resource, "priorMaps/plan");
  ASSERT_OK_AND_ASSIGN(const auto ties, graphs_.ReadPlanTies(Soon(), site_, {}));
  ASSERT_EQ(ties.size(), 1U);
  EXPECT_EQ(ties[0].prior_map, plan_);
  EXPECT_EQ(ties[0].bytes, "bytes");
  EXPECT_EQ(ties[0].sha256, Sha256("bytes"));
  ASSERT_OK_AND_ASSIGN(const auto known, graphs_.ReadPlanTies(Soon(), site_, {ties[0].sha256}));
  ASSERT_EQ(known.size(), 1U);
  EXPECT_EQ(known[0].bytes, "");

  ASSERT_OK(prior_maps_.Rename(Soon(), site_, plan_, 0, "Cellar"));
  EXPECT_EQ(*graphs_.GetVersion(Soon(), site_), first + 1);
  ASSERT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, {PriorMapState::kSuspended, "wrong"}));
  EXPECT_EQ(*graphs_.GetVersion(Soon(), site_), first + 2);
  EXPECT_THAT(*graphs_.ReadPlanTies(Soon(), site_, {}), ::testing::IsEmpty());
  ASSERT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, {PriorMapState::kActive, "right after all"}));
  ASSERT_OK(prior_maps_.Delete(Soon(), site_, plan_, 0, true));
  EXPECT_EQ(*graphs_.GetVersion(Soon(), site_), first + 4);
}

TEST_F(PriorMapStoreTest, ACorrectedPlanTiesNothingUntilItIsAlignedAgain) {
  ASSERT_OK(Create("plan", "Ground floor"));
  storage::PriorMapOutcome accepted =
      Accepted({{PriorMapProduct::kCorrected, "walls.svg", "<svg/>"}, {PriorMapProduct::kTies, "ties.bin", "ties"}});
  accepted.state = PriorMapState::kActive;
  ASSERT_OK_AND_ASSIGN(const PriorMap active, prior_maps_.SetOutcome(Soon(), site_, plan_, 0, accepted));
  ASSERT_EQ(graphs_.ReadPlanTies(Soon(), site_, {})->size(), 1U);
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graphs_.GetVersion(Soon(), site_));
  const storage::PriorMapElements elements{.walls = 10, .corners = 11, .doors = 12, .rooms = 13, .shafts = 14};
  const NewPriorMapFile plan{PriorMapProduct::kPlan, "plan", "corrected"};
  EXPECT_CODE(prior_maps_.ReplacePlan(Soon(), site_, plan_, active.etag - 1, elements, plan, "align"),
              absl::StatusCode::kAborted);
  EXPECT_CODE(prior_maps_.ReplacePlan(Soon(), site_, PriorMapId("other"), 0, elements, plan, "align"),
              absl::StatusCode::kNotFound);
  EXPECT_THAT(FilesOf(plan_),
              ::testing::ElementsAre("sheet.png: pixels", "plan: {}", "walls.svg: <svg/>", "ties.bin: ties"));
  ASSERT_OK_AND_ASSIGN(const PriorMap edited,
                       prior_maps_.ReplacePlan(Soon(), site_, plan_, active.etag, elements, plan, "align it again"));
  EXPECT_EQ(edited.state, PriorMapState::kNew);
  EXPECT_EQ(edited.reason, "align it again");
  EXPECT_EQ(edited.elements.walls, 10);
  EXPECT_EQ(edited.elements.shafts, 14);
  EXPECT_FALSE(edited.elements.metres_per_unit.has_value());
  ASSERT_TRUE(edited.alignment.has_value()) << "where to begin";
  EXPECT_EQ(edited.alignment->pairs.size(), 2U);
  EXPECT_NE(edited.etag, active.etag);
  EXPECT_THAT(FilesOf(plan_), ::testing::ElementsAre("sheet.png: pixels", "plan: corrected"));
  EXPECT_THAT(*graphs_.ReadPlanTies(Soon(), site_, {}), ::testing::IsEmpty());
  EXPECT_EQ(*graphs_.GetVersion(Soon(), site_), version + 1) << "it was in use";
  ASSERT_OK(prior_maps_.ReplacePlan(Soon(), site_, plan_, 0, elements, plan, "once more").status());
  EXPECT_EQ(*graphs_.GetVersion(Soon(), site_), version + 1) << "it was not in use";
}

TEST_F(PriorMapStoreTest, OneThatContradictsTheMapsDiverges) {
  ASSERT_OK(Create("plan", "Ground floor"));
  ASSERT_OK(Create("other", "First floor"));
  storage::PriorMapOutcome outcome = Accepted({{PriorMapProduct::kTies, "ties", "bytes"}});
  outcome.state = PriorMapState::kActive;
  ASSERT_OK_AND_ASSIGN(const PriorMap active, prior_maps_.SetOutcome(Soon(), site_, plan_, 0, outcome));
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graphs_.GetVersion(Soon(), site_));
  storage::GraphSolution solution;
  solution.contradicted_plans = {{plan_, "too many walls do not fit"}, {PriorMapId("other"), "it is not in use"}};
  ASSERT_OK(graphs_.Apply(Soon(), site_, version, solution));
  ASSERT_OK_AND_ASSIGN(const PriorMap diverged, prior_maps_.Get(Soon(), site_, plan_));
  EXPECT_EQ(diverged.state, PriorMapState::kDiverged);
  EXPECT_EQ(diverged.reason, "too many walls do not fit");
  EXPECT_NE(diverged.etag, active.etag);
  EXPECT_EQ(prior_maps_.Get(Soon(), site_, PriorMapId("other"))->state, PriorMapState::kNew);
  EXPECT_THAT(*graphs_.ReadPlanTies(Soon(), site_, {}), ::testing::IsEmpty());
}

TEST_F(PriorMapStoreTest, OneInUseIsDeletedByForceOnly) {
  ASSERT_OK(Create("plan", "Ground floor"));
  storage::PriorMapOutcome outcome = Accepted({{PriorMapProduct::kTies, "ties", "bytes"}});
  for (int i = 0; i < 6; ++i) outcome.alignment->maps.emplace_back("m" + std::to_string(i));
  outcome.state = PriorMapState::kActive;
  ASSERT_OK_AND_ASSIGN(const PriorMap active, prior_maps_.SetOutcome(Soon(), site_, plan_, 0, outcome));
  EXPECT_STATUS(prior_maps_.Delete(Soon(), site_, plan_, 0, false), absl::StatusCode::kFailedPrecondition,
                ::testing::HasSubstr("maps/hall"));
  EXPECT_STATUS(prior_maps_.Delete(Soon(), site_, plan_, active.etag, false), absl::StatusCode::kFailedPrecondition,
                ::testing::HasSubstr("maps/m2 and 3 more"));
  EXPECT_CODE(prior_maps_.Delete(Soon(), site_, plan_, active.etag + 1, false), absl::StatusCode::kAborted);
  EXPECT_EQ(prior_maps_.Get(Soon(), site_, plan_)->etag, active.etag);
  EXPECT_OK(prior_maps_.Delete(Soon(), site_, plan_, active.etag, true));
}

TEST_F(PriorMapStoreTest, OneIsPutToUseOnlyBesideThoseThatWereLookedAt) {
  for (const char* id : {"plan", "other"}) ASSERT_OK(Create(id, id));
  storage::PriorMapOutcome outcome = Accepted({});
  outcome.state = PriorMapState::kActive;
  outcome.beside.emplace();
  ASSERT_OK_AND_ASSIGN(const PriorMap other, prior_maps_.SetOutcome(Soon(), site_, PriorMapId("other"), 0, outcome));
  EXPECT_STATUS(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, outcome), absl::StatusCode::kAborted,
                ::testing::HasSubstr("priorMaps/other"));
  EXPECT_EQ(prior_maps_.Get(Soon(), site_, plan_)->state, PriorMapState::kNew);
  EXPECT_OK(prior_maps_.SetOutcome(Soon(), site_, PriorMapId("other"), 0, outcome)) << "it is not beside itself";
  outcome.beside->push_back(other.etag);
  EXPECT_CODE(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, outcome), absl::StatusCode::kAborted)
      << "it has been changed since";
  outcome.beside->push_back(prior_maps_.Get(Soon(), site_, PriorMapId("other"))->etag);
  EXPECT_OK(prior_maps_.SetOutcome(Soon(), site_, plan_, 0, outcome));
}

TEST_F(PriorMapStoreTest, MapsThatAreDeletedLeaveTheAlignment) {
  storage::Map lab;
  lab.site = site_;
  lab.id = MapId("lab");
  lab.display_name = "Lab";
  lab.environment = Environment::kIndoor;
  ASSERT_OK_AND_ASSIGN(const storage::Map made, maps_.Create(Soon(), lab, {}));
  std::vector<TimeNs> create_times = {maps_.Get(Soon(), site_, map_)->create_time, made.create_time};
  ASSERT_OK(Create("plan", "Ground floor"));
  storage::PriorMapOutcome outcome = Accepted({{PriorMapProduct::kTies, "ties", "bytes"}});
  outcome.state = PriorMapState::kActive;
  outcome.map_create_times = create_times;
  ASSERT_OK_AND_ASSIGN(const PriorMap both, prior_maps_.SetOutcome(Soon(), site_, plan_, 0, outcome));
  EXPECT_EQ(both.alignment->maps.size(), 2U);
  ASSERT_OK(maps_.Delete(Soon(), site_, lab.id, 0, true));
  ASSERT_OK_AND_ASSIGN(const PriorMap left, prior_maps_.Get(Soon(), site_, plan_));
  EXPECT_THAT(left.alignment->maps, ::testing::ElementsAre(map_));
  EXPECT_THAT(left.alignment->joined_maps, ::testing::IsEmpty());
  EXPECT_NE(left.etag, both.etag);
  EXPECT_THAT(graphs_.ReadPlanTies(Soon(), site_, {})->at(0).maps, ::testing::ElementsAre(map_));

  // The same alignment had been begun before, and ends only now; and hall is made again.
  create_times[0] -= 1000;
  outcome.map_create_times = create_times;
  ASSERT_OK_AND_ASSIGN(const PriorMap none, prior_maps_.SetOutcome(Soon(), site_, plan_, 0, outcome));
  EXPECT_THAT(none.alignment->maps, ::testing::IsEmpty());
}

TEST_F(PriorMapStoreTest, StaleEtagsChangeNothing) {
  ASSERT_OK_AND_ASSIGN(const PriorMap created, Create("plan", "Ground floor"));
  ASSERT_OK_AND_ASSIGN(const PriorMap renamed, prior_maps_.Rename(Soon(), site_, plan_, created.etag, "Cellar"));
  EXPECT_EQ(renamed.display_name, "Cellar");
  EXPECT_CODE(prior_maps_.Rename(Soon(), site_, plan_, created.etag, "Roof"), absl::StatusCode::kAborted);
  EXPECT_CODE(prior_maps_.SetOutcome(Soon(), site_, plan_, created.etag, Accepted({})), absl::StatusCode::kAborted);
  EXPECT_CODE(prior_maps_.SetOutcome(Soon(), site_, plan_, created.etag, {PriorMapState::kSuspended, ""}),
              absl::StatusCode::kAborted);
  EXPECT_CODE(prior_maps_.Delete(Soon(), site_, plan_, created.etag, true), absl::StatusCode::kAborted);
  ASSERT_OK_AND_ASSIGN(const PriorMap found, prior_maps_.Get(Soon(), site_, plan_));
  EXPECT_EQ(found.etag, renamed.etag);
  EXPECT_EQ(found.display_name, "Cellar");
  ASSERT_OK(prior_maps_.Delete(Soon(), site_, plan_, found.etag, true));
  EXPECT_CODE(prior_maps_.Get(Soon(), site_, plan_), absl::StatusCode::kNotFound);
  EXPECT_CODE(prior_maps_.Delete(Soon(), site_, plan_, 0, true), absl::StatusCode::kNotFound);
}

TEST_F(PriorMapStoreTest, ItsFilesAreKeptAsLongAsItIsThere) {
  ASSERT_OK(Create("plan", "Ground floor"));
  const storage::Maintenance maintenance(*pool_);
  database_.Sql("UPDATE enfilade.blobs SET put_time = now() - interval '1 day'");
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  EXPECT_THAT(FilesOf(plan_), ::testing::ElementsAre("sheet.png: pixels", "plan: {}"));
  ASSERT_OK(prior_maps_.Delete(Soon(), site_, plan_, 0, true));
  ASSERT_OK(maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 1000));
  EXPECT_CODE(blobs_.Get(Soon(), site_, Sha256("pixels")), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
