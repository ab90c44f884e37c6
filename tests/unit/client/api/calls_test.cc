// SPDX-License-Identifier: Apache-2.0
// Unary calls, lists of many pages, and finding maps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <thread>
#include <vector>

#include "client/sdk/api/maps.h"
#include "client/sdk/api/paging.h"
#include "client/sdk/connection.h"
#include "tests/support/scripted_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using MapStub = v1::MapService::Stub;

class CallsTest : public ::testing::Test {
 protected:
  // A list of `total` maps named 0, 1, ... in pages of at most `page`; the token is the next index.
  void ServeList(int total, int page) {
    server_.maps.list_maps = [this, total, page](const v1::ListMapsRequest& request, v1::ListMapsResponse& response) {
      requests_.push_back(request);
      const int asked = request.page_size() > 0 ? request.page_size() : page;
      int next = request.page_token().empty() ? 0 : std::stoi(request.page_token());
      for (const int end = std::min(total, next + std::min(asked, page)); next < end; ++next) {
        response.add_maps()->set_name(std::to_string(next));
      }
      if (next < total) response.set_next_page_token(std::to_string(next));
      return grpc::Status::OK;
    };
  }
  absl::StatusOr<std::vector<v1::Map>> List(int limit = 0, const v1::ListMapsRequest& request = {}) {
    return ListAll(connection_, &MapStub::ListMaps, request, &v1::ListMapsResponse::maps, limit);
  }

  testing::TemporaryDirectory directory_;
  testing::ScriptedServer server_{(directory_.path() / "s").string()};
  const Connection connection_{server_.address(), std::chrono::seconds(20), "ann"};
  std::vector<v1::ListMapsRequest> requests_;
};

TEST_F(CallsTest, AListHasEveryItemOnceWhateverThePages) {
  for (const int total : {0, 1, 4, 5, 6, 23}) {
    for (const int page : {1, 5, 100}) {
      ServeList(total, page);
      ASSERT_OK_AND_ASSIGN(const std::vector<v1::Map> maps, List());
      ASSERT_EQ(maps.size(), static_cast<std::size_t>(total)) << page;
      for (int i = 0; i < total; ++i) EXPECT_EQ(maps[static_cast<std::size_t>(i)].name(), std::to_string(i));
    }
  }
}

TEST_F(CallsTest, ALimitEndsTheListAndSizesThePages) {
  ServeList(5000, 1000);
  ASSERT_OK_AND_ASSIGN(const std::vector<v1::Map> maps, List(2500));
  EXPECT_EQ(maps.size(), 2500U);
  ASSERT_EQ(requests_.size(), 3U);
  EXPECT_EQ(requests_[0].page_size(), 1000);
  EXPECT_EQ(requests_[2].page_size(), 500);
  requests_.clear();
  ASSERT_OK_AND_ASSIGN(const std::vector<v1::Map> few, List(3));
  EXPECT_EQ(few.size(), 3U);
  EXPECT_EQ(requests_.size(), 1U);
  ServeList(2, 1000);
  ASSERT_OK_AND_ASSIGN(const std::vector<v1::Map> all, List(10));
  EXPECT_EQ(all.size(), 2U);
}

TEST_F(CallsTest, AServerThatSendsMoreThanAskedDoesNotExceedTheLimit) {
  server_.maps.list_maps = [](const v1::ListMapsRequest&, v1::ListMapsResponse& response) {
    for (int i = 0; i < 9; ++i) response.add_maps();
    response.set_next_page_token("more");
    return grpc::Status::OK;
  };
  ASSERT_OK_AND_ASSIGN(const std::vector<v1::Map> maps, List(4));
  EXPECT_EQ(maps.size(), 4U);
}

TEST_F(CallsTest, TheRequestsFiltersGoWithEveryPage) {
  ServeList(3, 1);
  v1::ListMapsRequest request;
  request.set_parent("sites/s");
  ASSERT_OK(List(0, request));
  ASSERT_EQ(requests_.size(), 3U);
  for (const v1::ListMapsRequest& sent : requests_) EXPECT_EQ(sent.parent(), "sites/s");
  v1::ListMapsRequest from_the_middle;
  from_the_middle.set_page_token("2");
  ASSERT_OK_AND_ASSIGN(const std::vector<v1::Map> rest, List(0, from_the_middle));
  EXPECT_EQ(rest.size(), 1U);
}

TEST_F(CallsTest, AListEndsAtTheFirstErrorAndNeverTurnsInCircles) {
  server_.maps.list_maps = [](const v1::ListMapsRequest& request, v1::ListMapsResponse& response) {
    if (!request.page_token().empty()) return grpc::Status(grpc::StatusCode::ABORTED, "changed meanwhile");
    response.add_maps();
    response.set_next_page_token("2");
    return grpc::Status::OK;
  };
  EXPECT_STATUS(List(), absl::StatusCode::kAborted, HasSubstr("changed meanwhile"));
  server_.maps.list_maps = [](const v1::ListMapsRequest&, v1::ListMapsResponse& response) {
    response.set_next_page_token("same");
    return grpc::Status::OK;
  };
  EXPECT_STATUS(List(), absl::StatusCode::kInternal, HasSubstr("repeats a page"));
}

TEST_F(CallsTest, EveryUnaryCallHasDeadlineAndActor) {
  ServeList(0, 1);
  ASSERT_OK(List());
  ASSERT_EQ(server_.calls().size(), 1U);
  EXPECT_EQ(server_.calls()[0].actor, "ann");
  ASSERT_TRUE(server_.calls()[0].seconds_to_live.has_value());
  EXPECT_GT(*server_.calls()[0].seconds_to_live, 0.0);
  EXPECT_LE(*server_.calls()[0].seconds_to_live, 25.0);
}

TEST_F(CallsTest, ActorsAreSentAsPrintableAscii) {
  ServeList(0, 1);
  const std::pair<std::string, std::string> cases[] = {
      {"Ann B.", "Ann B."}, {"J\xc3\xb6rg", "J??rg"}, {"a\nb\x7f", "a?b?"}, {"", ""}};
  for (const auto& [actor, sent] : cases) {
    const Connection connection(server_.address(), std::chrono::seconds(20), actor);
    ASSERT_OK(connection.Call(&MapStub::ListMaps, v1::ListMapsRequest()));
    EXPECT_EQ(server_.calls().back().actor, sent);
  }
}

TEST_F(CallsTest, ACallThatTakesTooLongEndsAtItsDeadline) {
  server_.maps.list_maps = [](const v1::ListMapsRequest&, v1::ListMapsResponse&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    return grpc::Status::OK;
  };
  const Connection impatient(server_.address(), std::chrono::milliseconds(50));
  EXPECT_CODE(impatient.Call(&MapStub::ListMaps, v1::ListMapsRequest()), absl::StatusCode::kDeadlineExceeded);
}

TEST_F(CallsTest, AServerThatIsAwayIsNamedAndFoundAgain) {
  ServeList(1, 1);
  ASSERT_OK(List());
  server_.Stop();
  EXPECT_STATUS(List(), absl::StatusCode::kUnavailable, HasSubstr(server_.address()));
  server_.Start();
  absl::Status status = absl::UnavailableError("");
  for (int i = 0; i < 200 && absl::IsUnavailable(status); ++i) {
    status = List().status();
    if (!status.ok()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_OK(status);
}

TEST(FromGrpcStatusTest, KeepsCodesAndMessages) {
  EXPECT_OK(FromGrpcStatus(grpc::Status::OK, "a"));
  const grpc::Status refused(grpc::StatusCode::FAILED_PRECONDITION, "not now");
  EXPECT_STATUS(FromGrpcStatus(refused, "a"), absl::StatusCode::kFailedPrecondition, ::testing::Eq("not now"));
  const grpc::Status away(grpc::StatusCode::UNAVAILABLE, "refused");
  EXPECT_STATUS(FromGrpcStatus(away, "host:1"), absl::StatusCode::kUnavailable, HasSubstr("host:1"));
  EXPECT_STATUS(FromGrpcStatus(away), absl::StatusCode::kUnavailable, ::testing::Eq("refused"));
}

class FindMapTest : public CallsTest {
 protected:
  FindMapTest() {
    server_.maps.list_maps = [this](const v1::ListMapsRequest& request, v1::ListMapsResponse& response) {
      EXPECT_EQ(request.parent(), "sites/s");
      for (const auto& [name, display_name] : maps_) {
        if (display_name == request.display_name()) response.add_maps()->set_name(name);
      }
      return grpc::Status::OK;
    };
    server_.maps.get_map = [this](const v1::GetMapRequest& request, v1::GetMapResponse& response) {
      if (!maps_.contains(request.name())) return grpc::Status(get_error_, "get");
      response.mutable_map()->set_name(request.name());
      return grpc::Status::OK;
    };
    server_.maps.create_map = [this](const v1::CreateMapRequest& request, v1::CreateMapResponse& response) {
      created_.push_back(request);
      if (create_error_ != grpc::StatusCode::OK) {
        if (create_error_ == grpc::StatusCode::ALREADY_EXISTS) maps_["sites/s/maps/other"] = "Attic";
        return grpc::Status(create_error_, "create");
      }
      response.mutable_map()->set_name("sites/s/maps/new");
      return grpc::Status::OK;
    };
  }
  absl::StatusOr<std::string> Find(const std::string& map) { return NameOf(FindMap(connection_, SiteId("s"), map)); }
  absl::StatusOr<std::string> FindOrCreate(const std::string& map) {
    v1::CreateMapRequest request;
    request.mutable_map()->set_display_name(map);
    return NameOf(FindOrCreateMap(connection_, SiteId("s"), map, request));
  }
  static absl::StatusOr<std::string> NameOf(const absl::StatusOr<v1::Map>& map) {
    if (!map.ok()) return map.status();
    return map->name();
  }

  std::map<std::string, std::string> maps_ = {
      {"sites/s/maps/hall", "Main hall"}, {"sites/s/maps/lab", "hall"}, {"sites/s/maps/x", "x"}};
  grpc::StatusCode get_error_ = grpc::StatusCode::NOT_FOUND;
  grpc::StatusCode create_error_ = grpc::StatusCode::OK;
  std::vector<v1::CreateMapRequest> created_;
};

TEST_F(FindMapTest, DisplayNamesComeBeforeIdsAndResourceNames) {
  EXPECT_EQ(*Find("Main hall"), "sites/s/maps/hall");
  EXPECT_EQ(*Find("hall"), "sites/s/maps/lab") << "its display name wins over another map's id";
  EXPECT_EQ(*Find("lab"), "sites/s/maps/lab");
  EXPECT_EQ(*Find("sites/s/maps/hall"), "sites/s/maps/hall");
}

TEST_F(FindMapTest, WhatIsNoMapIsNotFound) {
  for (const std::string map : {"cellar", "Main  hall", "", "sites/s/maps/none", "sites/other"}) {
    EXPECT_STATUS(Find(map), absl::StatusCode::kNotFound, HasSubstr("\"" + map + "\""));
  }
  get_error_ = grpc::StatusCode::INVALID_ARGUMENT;
  EXPECT_CODE(Find("sites/odd"), absl::StatusCode::kNotFound);
  get_error_ = grpc::StatusCode::INTERNAL;
  EXPECT_CODE(Find("cellar"), absl::StatusCode::kInternal);
  server_.maps.list_maps = nullptr;
  EXPECT_CODE(Find("hall"), absl::StatusCode::kUnimplemented);
}

TEST_F(FindMapTest, OnlyAMissingMapIsCreated) {
  EXPECT_EQ(*FindOrCreate("Main hall"), "sites/s/maps/hall");
  EXPECT_THAT(created_, IsEmpty());
  EXPECT_EQ(*FindOrCreate("Cellar"), "sites/s/maps/new");
  ASSERT_EQ(created_.size(), 1U);
  EXPECT_EQ(created_[0].parent(), "sites/s");
  EXPECT_EQ(created_[0].map().display_name(), "Cellar");
  create_error_ = grpc::StatusCode::ALREADY_EXISTS;
  EXPECT_EQ(*FindOrCreate("Attic"), "sites/s/maps/other") << "another client was faster";
  create_error_ = grpc::StatusCode::PERMISSION_DENIED;
  EXPECT_CODE(FindOrCreate("Roof"), absl::StatusCode::kPermissionDenied);
  get_error_ = grpc::StatusCode::INTERNAL;
  created_.clear();
  EXPECT_CODE(FindOrCreate("roof"), absl::StatusCode::kInternal);
  EXPECT_THAT(created_, IsEmpty()) << "not known whether it is missing";
}

}  // namespace
}  // namespace enfilade::client
