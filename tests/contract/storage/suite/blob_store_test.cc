// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/blob_store.h"

#include <thread>

#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

class BlobStoreTest : public StoreContractTest {};

std::string Noise(std::size_t size) {
  std::string data(size, '\0');
  std::uint64_t state = 88172645463325252ULL;
  for (char& byte : data) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    byte = static_cast<char>(state);
  }
  return data;
}

TEST_F(BlobStoreTest, StoresTheSameBytesOnce) {
  const TestBlob blob("content");
  ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view(), blob.view()}));
  ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
  EXPECT_EQ(backend_->CountBlobs(), 1);
  ASSERT_OK_AND_ASSIGN(const std::string data, blobs_.Get(Soon(), site_, blob.sha256()));
  EXPECT_EQ(data, "content");
}

TEST_F(BlobStoreTest, ManyAreReadAtOnceUnlessOneIsMissing) {
  const TestBlob one("one"), two("two"), missing("missing");
  ASSERT_OK(blobs_.Put(Soon(), site_, {one.view(), two.view()}));
  ASSERT_OK_AND_ASSIGN(const auto both, blobs_.GetAll(Soon(), site_, {two.sha256(), one.sha256(), two.sha256()}));
  EXPECT_THAT(both, ::testing::UnorderedElementsAre(::testing::Pair(one.sha256(), "one"),
                                                    ::testing::Pair(two.sha256(), "two")));
  EXPECT_STATUS(blobs_.GetAll(Soon(), site_, {one.sha256(), missing.sha256()}), absl::StatusCode::kNotFound,
                ::testing::HasSubstr("does not exist"));
  ASSERT_OK_AND_ASSIGN(const auto none, blobs_.GetAll(Soon(), site_, {}));
  EXPECT_TRUE(none.empty());
}

TEST_F(BlobStoreTest, RefusesBytesThatAreNotWhatWasSaid) {
  const TestBlob good("good");
  const TestBlob other("other");
  EXPECT_CODE(blobs_.Put(Soon(), site_, {good.view(), {other.sha256(), "evil"}}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(blobs_.Put(Soon(), site_, {TestBlob("").view()}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(blobs_.Get(Soon(), site_, good.sha256()), absl::StatusCode::kNotFound);
  EXPECT_CODE(blobs_.Put(Soon(), SiteId("nowhere"), {good.view()}), absl::StatusCode::kNotFound);
}

TEST_F(BlobStoreTest, TheLargestBlobComesBackWhole) {
  const TestBlob blob(Noise(sensor::kMaxBlobBytes));
  ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
  ASSERT_OK_AND_ASSIGN(const std::string data, blobs_.Get(Soon(), site_, blob.sha256()));
  EXPECT_TRUE(data == blob.data());
  const TestBlob too_large(std::string(sensor::kMaxBlobBytes + 1, 'x'));
  EXPECT_CODE(blobs_.Put(Soon(), site_, {too_large.view()}), absl::StatusCode::kInvalidArgument);
}

TEST_F(BlobStoreTest, BelongsToItsSite) {
  const TestBlob blob("content");
  ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
  backend_->AddSite(SiteId("other"));
  EXPECT_CODE(blobs_.Get(Soon(), SiteId("other"), blob.sha256()), absl::StatusCode::kNotFound);
}

TEST_F(BlobStoreTest, ManyMayPutTheSameAtOnce) {
  std::vector<TestBlob> blobs;
  for (int i = 0; i < 20; ++i) blobs.emplace_back("blob " + std::to_string(i));
  std::vector<absl::Status> outcomes(8);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < outcomes.size(); ++t) {
    threads.emplace_back([&, t] {
      std::vector<storage::BlobView> views;
      for (std::size_t i = 0; i < blobs.size(); ++i) views.push_back(blobs[(i * (t + 1) * 3) % blobs.size()].view());
      for (int round = 0; round < 5 && outcomes[t].ok(); ++round) outcomes[t] = blobs_.Put(Soon(), site_, views);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const absl::Status& outcome : outcomes) EXPECT_OK(outcome);
}

}  // namespace
}  // namespace enfilade::testing
