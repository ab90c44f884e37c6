// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/graph.h"
#include "client/sdk/api/graph_export.h"
#include "tests/rpc/graph_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Stub = v1::GraphService::Stub;

class GraphPagesTest : public GraphTest {
 protected:
  static v1::GetGraphRequest PageOf(int size, const std::string& token = "") {
    v1::GetGraphRequest request;
    request.set_site("sites/s");
    request.set_page_size(size);
    request.set_page_token(token);
    request.set_with_edges(true);
    return request;
  }
  // Rooms in the graph, as the triggers would write them, and for each a door from map "m"; seen by a new server.
  void AddRooms(int rooms, int doors) {
    const std::string counts = fmt::format("generate_series(1, {}) i", rooms);
    database_.Sql(
        "SET session_replication_role = replica;"
        "INSERT INTO enfilade.maps (site_id, map_id, display_name, environment)"
        " SELECT 's', 'room-' || i, 'Big room ' || i, 1 FROM " +
        counts +
        ";INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version, x, y, yaw, covariance)"
        " SELECT 's', 'room-' || i, 1, i, 0, 0, array_fill(0.01::float8, '{9}') FROM " +
        counts);
    database_.Sql(fmt::format(
        "SET session_replication_role = replica;"
        "INSERT INTO enfilade.link_points (site_id, link_point_id, kind, anchor_count, levels, changed_version)"
        " SELECT 's', 'door-' || i, 1, 2, '{{[0,0]}}', 1 FROM generate_series(1, {0}) i;"
        "INSERT INTO enfilade.link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)"
        " SELECT 's', 'door-' || i, m, n, i, 0, 0, '{{0.003,0,0,0,0.003,0,0,0,0.003}}' FROM generate_series(1, {0}) i,"
        " LATERAL (VALUES ('m', 1), ('room-' || i, 2)) v (m, n)",
        doors));
    Restart(Options());
  }
};

TEST_F(GraphPagesTest, PagesAreTheWholeGraph) {
  const v1::Graph whole = AwaitSolution();
  for (const int size : {1, 2, 3, 1000}) {
    v1::Graph read;
    std::string token;
    int pages = 0;
    do {
      ASSERT_OK_AND_ASSIGN(const v1::GetGraphResponse page, Call(&Stub::GetGraph, PageOf(size, token)));
      EXPECT_LE(page.graph().maps_size() + page.graph().link_points_size() + page.graph().edges_size(), size);
      read.MergeFrom(page.graph());
      token = page.next_page_token();
      ++pages;
    } while (!token.empty());
    EXPECT_EQ(read.SerializeAsString(), whole.SerializeAsString());
    EXPECT_EQ(pages, (7 + size - 1) / size) << "4 maps, 2 link points, 1 edge";
  }
  v1::GetGraphRequest request = PageOf(1000);
  request.set_with_edges(false);
  ASSERT_OK_AND_ASSIGN(const v1::GetGraphResponse page, Call(&Stub::GetGraph, request));
  EXPECT_EQ(page.graph().link_points_size(), 2);
  EXPECT_THAT(page.graph().edges(), IsEmpty()) << "they were not asked for";
}

TEST_F(GraphPagesTest, PagesAreOfOneVersionHoweverOftenTheGraphChanges) {
  const v1::Graph whole = AwaitSolution();
  v1::Graph read;
  std::string token;
  int changes = 0;
  do {
    ASSERT_OK_AND_ASSIGN(const v1::GetGraphResponse page, Call(&Stub::GetGraph, PageOf(1, token)));
    read.MergeFrom(page.graph());
    token = page.next_page_token();
    for (int i = 0; i < 4; ++i) {  // more in all than the server keeps versions
      const storage::StoredLinkPoint made =
          Join(fmt::format("new-{}", ++changes), "m", "far", {3.0 * changes, 0, 0}, {3.0 * changes, 0, 0});
      AwaitGraph([&](const v1::Graph& graph) { return graph.graph_version() >= made.point.graph_version; });
    }
  } while (!token.empty());
  EXPECT_EQ(read.SerializeAsString(), whole.SerializeAsString());
}

TEST_F(GraphPagesTest, AVersionThatIsGoneIsAborted) {
  ASSERT_OK_AND_ASSIGN(const v1::GetGraphResponse first, Call(&Stub::GetGraph, PageOf(1)));
  Join("new", "m", "far");
  Restart(Options());
  EXPECT_STATUS(Call(&Stub::GetGraph, PageOf(1, first.next_page_token())), absl::StatusCode::kAborted,
                HasSubstr("begin again"));
  ASSERT_OK_AND_ASSIGN(const v1::Graph read, client::ReadGraph(*connection_, "sites/s"));
  EXPECT_EQ(read.link_points_size(), 3);
}

TEST_F(GraphPagesTest, WrongPagesAreRefused) {
  ASSERT_OK_AND_ASSIGN(const v1::GetGraphResponse first, Call(&Stub::GetGraph, PageOf(1)));
  EXPECT_CODE(Call(&Stub::GetGraph, PageOf(-1)), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::GetGraph, PageOf(1, "nonsense")), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Call(&Stub::GetGraph, PageOf(1, "cDE6Nw")), absl::StatusCode::kInvalidArgument) << "p1:7, of a list";
  v1::GetGraphRequest other = PageOf(1, first.next_page_token());
  other.set_graph_version(first.graph().graph_version() + 1);
  EXPECT_STATUS(Call(&Stub::GetGraph, other), absl::StatusCode::kInvalidArgument, HasSubstr("page_token continues"));
}

TEST_F(GraphPagesTest, ALargeGraphIsNeverOneMessage) {
  AddRooms(20'000, 0);
  v1::GetGraphRequest whole;
  whole.set_site("sites/s");
  EXPECT_STATUS(Call(&Stub::GetGraph, whole), absl::StatusCode::kResourceExhausted,
                HasSubstr("20004 maps, 2 link points and 1 edges, more than 10000 for one answer: set page_size"));
  ASSERT_OK_AND_ASSIGN(const v1::GetGraphResponse page, Call(&Stub::GetGraph, PageOf(1'000'000)));
  EXPECT_EQ(page.graph().maps_size(), 1000) << "no page is larger";
  EXPECT_LT(page.ByteSizeLong(), std::size_t{1} << 20);
  ASSERT_OK_AND_ASSIGN(const v1::Graph read, client::ReadGraph(*connection_, "sites/s", {.with_edges = true}));
  EXPECT_EQ(read.maps_size(), 20'004);
  EXPECT_EQ(read.link_points_size(), 2);
  EXPECT_EQ(read.edges_size(), 1);
}

TEST_F(GraphPagesTest, ACorridorWithManyDoorsSendsEdgesOnRequestOnly) {
  AddRooms(2000, 2000);
  v1::GetGraphRequest whole;
  whole.set_site("sites/s");
  EXPECT_STATUS(Call(&Stub::GetGraph, whole), absl::StatusCode::kResourceExhausted, HasSubstr("2001001 edges"));
  ASSERT_OK_AND_ASSIGN(const v1::Graph read, client::ReadGraph(*connection_, "sites/s"));
  EXPECT_EQ(read.link_points_size(), 2002);
  EXPECT_LT(read.ByteSizeLong(), std::size_t{2} << 20);
  EXPECT_STATUS(client::ExportGraph(*connection_, site_), absl::StatusCode::kResourceExhausted,
                HasSubstr("set without_edges"));
  ASSERT_OK_AND_ASSIGN(const client::ExportedGraph exported,
                       client::ExportGraph(*connection_, site_, {.with_edges = false}));
  EXPECT_LT(exported.geojson.size(), std::size_t{4} << 20);
}

}  // namespace
}  // namespace enfilade::testing
