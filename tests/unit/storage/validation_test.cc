// SPDX-License-Identifier: Apache-2.0
// The rules of logs, blobs, maps and mapping that hold whatever stores the data.
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "core/base/sha256.h"
#include "core/sensor/record_codec.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "tests/support/status_assertions.h"

namespace enfilade::storage {
namespace {

using ::testing::HasSubstr;

sensor::Record OdometryAt(std::int64_t sequence, double x = 0.0) {
  return {sequence, sensor::Odometry{sequence, {x, 0, 0}}};
}

TEST(ValidateBatchTest, SequencesStartAtOneAndIncrease) {
  const SiteId site("s");
  const SessionId session("t");
  struct Case {
    std::vector<std::int64_t> sequences;
    std::int64_t refused = 0;  // 0: valid
  };
  const std::vector<Case> cases = {{{}, 0},    {{1}, 0},    {{1, 2, 3}, 0},    {{5, 9, 100}, 0}, {{0}, 0},
                                   {{-3}, -3}, {{1, 1}, 1}, {{2, 3, 3, 4}, 3}, {{5, 4}, 4},      {{1, 2, 0}, 0}};
  for (const Case& test : cases) {
    std::vector<sensor::Record> records;
    for (const std::int64_t sequence : test.sequences) records.push_back(OdometryAt(sequence));
    const auto& sequences = test.sequences;
    const bool increasing =
        std::adjacent_find(sequences.begin(), sequences.end(), std::greater_equal<>()) == sequences.end();
    const bool valid = increasing && (sequences.empty() || sequences.front() >= 1);
    const absl::Status status = ValidateBatch({site, session, records, {}});
    EXPECT_CODE(status, valid ? absl::StatusCode::kOk : absl::StatusCode::kInvalidArgument)
        << ::testing::PrintToString(sequences);
    EXPECT_EQ(RefusedSequenceOf(status), test.refused) << ::testing::PrintToString(test.sequences);
  }
}

TEST(ValidateBlobsTest, ChecksDigestAndSize) {
  const std::string data = "content", other = "other";
  const std::string digest = Sha256(data), other_digest = Sha256(other);
  EXPECT_OK(ValidateBlobs({}));
  const std::vector<BlobView> good = {{digest, data}, {other_digest, other}, {digest, data}};
  EXPECT_OK(ValidateBlobs(good));
  const std::vector<BlobView> wrong = {{digest, data}, {digest, other}};
  EXPECT_STATUS(ValidateBlobs(wrong), absl::StatusCode::kInvalidArgument, HasSubstr(ToHex(other_digest)));
  const std::string empty_digest = Sha256("");
  const std::vector<BlobView> empty = {{empty_digest, ""}};
  EXPECT_STATUS(ValidateBlobs(empty), absl::StatusCode::kInvalidArgument, HasSubstr("0 bytes"));
  const std::vector<BlobView> short_digest = {{std::string_view(digest).substr(1), data}};
  EXPECT_CODE(ValidateBlobs(short_digest), absl::StatusCode::kInvalidArgument);
}

TEST(ValidateBlobSizeTest, NamesTheRecordAndBothSizes) {
  const sensor::BlobRef blob{Sha256("x"), 6};
  const sensor::Record record{41, sensor::Image{0, sensor::Camera::kRear, sensor::ImageEncoding::kPng, blob}};
  EXPECT_OK(ValidateBlobSize(record, blob, 6));
  const absl::Status missing = ValidateBlobSize(record, blob, 0);
  EXPECT_STATUS(missing, absl::StatusCode::kInvalidArgument, HasSubstr("was not sent"));
  EXPECT_EQ(RefusedSequenceOf(missing), 41);
  const absl::Status longer = ValidateBlobSize(record, blob, 5);
  EXPECT_STATUS(longer, absl::StatusCode::kInvalidArgument, HasSubstr("has 5 bytes, not 6"));
  EXPECT_EQ(RefusedSequenceOf(longer), 41);
}

TEST(RefusedSequenceTest, ComesBackFromTheStatusOnly) {
  EXPECT_EQ(RefusedSequenceOf(absl::OkStatus()), 0);
  EXPECT_EQ(RefusedSequenceOf(absl::AlreadyExistsError("record 5")), 0);
  for (const std::int64_t sequence :
       {std::int64_t{1}, std::int64_t{12'345}, std::numeric_limits<std::int64_t>::max()}) {
    const absl::Status status = RefuseRecord(absl::AlreadyExistsError("x"), sequence);
    EXPECT_EQ(RefusedSequenceOf(status), sequence);
    EXPECT_CODE(status, absl::StatusCode::kAlreadyExists);
  }
}

TEST(HasContentTest, ComparesKindAndPayloadByValue) {
  const sensor::Record record = OdometryAt(3, 1.5);
  const std::string payload = sensor::EncodePayload(record);
  EXPECT_TRUE(HasContent(record, sensor::RecordKind::kOdometry, payload));
  EXPECT_FALSE(HasContent(OdometryAt(3, 1.5000001), sensor::RecordKind::kOdometry, payload));
  EXPECT_FALSE(HasContent(record, sensor::RecordKind::kLaserScan, payload));
  EXPECT_FALSE(HasContent(record, sensor::RecordKind::kOdometry, payload.substr(1)));
  EXPECT_FALSE(HasContent(record, sensor::RecordKind::kOdometry, ""));
}

TEST(LayersChangedTest, IsToldFromOtherAbortions) {
  const absl::Status changed = LayersChanged(SiteId("campus"), MapId("hall"));
  EXPECT_STATUS(changed, absl::StatusCode::kAborted, HasSubstr("sites/campus/maps/hall"));
  EXPECT_TRUE(AreLayersChanged(changed));
  EXPECT_FALSE(AreLayersChanged(absl::AbortedError(changed.message())));
  EXPECT_FALSE(AreLayersChanged(absl::OkStatus()));
}

TEST(ValidateStepTest, AStepGoesForwardAndEndsOnlyAFinishedSession) {
  struct Case {
    std::string name;
    MappingProgress progress;
    std::int64_t mapped_sequence = 10;
    std::optional<SessionState> final_state;
    absl::StatusCode expected = absl::StatusCode::kOk;
  };
  const auto kRecording = SessionState::kRecording, kFinished = SessionState::kFinished;
  const auto kMapped = SessionState::kMapped, kFailed = SessionState::kFailed;
  const auto kInvalid = absl::StatusCode::kInvalidArgument, kTooEarly = absl::StatusCode::kFailedPrecondition;
  const std::vector<Case> cases = {
      {"forward", {kRecording, 9}, 10, std::nullopt},
      {"the same again", {kRecording, 10}, 10, std::nullopt},
      {"back", {kRecording, 11}, 10, std::nullopt, kInvalid},
      {"back at the end", {kFinished, 11}, 10, kMapped, kInvalid},
      {"the end of a finished session", {kFinished, 10}, 10, kMapped},
      {"the end of a session that records", {kRecording, 10}, 10, kMapped, kTooEarly},
      {"the end again", {kMapped, 10}, 10, kMapped},
      {"the end of a failed session", {kFailed, 10}, 10, kMapped, kTooEarly},
      {"a failure while recording", {kRecording, 10}, 10, kFailed},
      {"a failure after the end", {kMapped, 10}, 10, kFailed},
      {"a state that is not final", {kFinished, 10}, 10, kFinished, kInvalid},
      {"another one", {kFinished, 10}, 10, kRecording, kInvalid},
  };
  const SessionLease lease{SiteId("campus"), SessionId("s1"), "worker", 1};
  const slam::SlamDelta nothing;
  for (const Case& test : cases) {
    const MappingStep step{nothing, "", {}, test.mapped_sequence, nullptr, {}, test.final_state, ""};
    const absl::Status status = ValidateStep(lease, test.progress, step);
    EXPECT_CODE(status, test.expected) << test.name;
    if (!status.ok() && test.expected == kTooEarly) {
      EXPECT_THAT(std::string(status.message()), HasSubstr("sites/campus/sessions/s1"));
    }
  }
}

TEST(LeaseLostTest, NamesOwnerAndSession) {
  EXPECT_STATUS(LeaseLost({SiteId("campus"), SessionId("s1"), "worker 7", 3}), absl::StatusCode::kAborted,
                ::testing::AllOf(HasSubstr("worker 7"), HasSubstr("sites/campus/sessions/s1")));
}

TEST(ValidateOutlineTest, NeedsThreeFiniteCornersOrNone) {
  struct Case {
    std::vector<Eigen::Vector2d> outline;
    bool valid;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const std::vector<Case> cases = {{{}, true},
                                   {{{0, 0}}, false},
                                   {{{0, 0}, {1, 0}}, false},
                                   {{{0, 0}, {1, 0}, {1, 1}}, true},
                                   {{{0, 0}, {1, nan}, {1, 1}}, false},
                                   {{{0, 0}, {infinity, 0}, {1, 1}}, false},
                                   {{{nan, 0}}, false}};
  for (const Case& test : cases) {
    Map map;
    map.outline = test.outline;
    EXPECT_CODE(ValidateOutline(map), test.valid ? absl::StatusCode::kOk : absl::StatusCode::kInvalidArgument)
        << test.outline.size();
  }
}

TEST(ValidateUnusedTest, ListsWhatRefersToTheMapButNotAllOfIt) {
  const SiteId site("campus");
  const MapId map("hall");
  EXPECT_OK(ValidateUnused(site, map, {}));
  EXPECT_STATUS(ValidateUnused(site, map, {{"s1", "s2"}, {}}), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/maps/hall: 2 sessions map into it: s1, s2. Delete them first"));
  EXPECT_STATUS(ValidateUnused(site, map, {{}, {"p1"}}), absl::StatusCode::kFailedPrecondition,
                HasSubstr("hall: 1 link points join it: p1."));
  EXPECT_STATUS(ValidateUnused(site, map, {{"s1"}, {"1", "2", "3", "4", "5", "6", "7"}}),
                absl::StatusCode::kFailedPrecondition,
                HasSubstr("1 sessions map into it: s1; 7 link points join it: 1, 2, 3, 4, 5 and 2 more."));
}

}  // namespace
}  // namespace enfilade::storage
