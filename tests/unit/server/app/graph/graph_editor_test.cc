// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_editor.h"

#include <functional>
#include <vector>

#include "core/base/sha256.h"
#include "tests/unit/server/app/graph/graph_test.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;

// The store reports nothing: a new version is answered with only if the editor has marked the graph as changed.
class GraphEditorTest : public AppGraphTest {
 protected:
  GraphEditorTest() {
    probe_.set_listening(GraphStoreProbe::Listening::kSilent);
    StartListening();
    editor_.emplace(GraphEditor::Stores{stores_.maps, stores_.link_points, probe_}, *graphs_);
  }

  std::optional<GraphEditor> editor_;
};

storage::StoredLinkPoint Candidate(const SiteId& site, const std::string& id, const std::string& map, double x) {
  storage::StoredLinkPoint candidate = MakeDoor(site, id, map, "", {x, 3, 0});
  candidate.point.anchors.pop_back();
  return candidate;
}

TEST_F(GraphEditorTest, EveryEditIsInTheNextAnswer) {
  struct Edit {
    const char* name;
    std::function<absl::Status()> make;
    std::function<bool(const SiteGraph&)> is_in;
  };
  const auto link_point = [](const SiteGraph& graph, const char* id) {
    return graph.graph().FindLinkPoint(LinkPointId(id));
  };
  const auto has_map = [](const SiteGraph& graph, const char* id) { return graph.graph().MapSlot(MapId(id)) >= 0; };
  const std::string content = "an image";
  const std::string sha256 = Sha256(content);
  ASSERT_OK(stores_.blobs.Put(Soon(), site_, {{sha256, content}}));

  // Each builds on those before it.
  const Edit edits[] = {
      {"CreateMap", [&] { return editor_->CreateMap(Soon(), MakeMap(site_, "d"), "").status(); },
       [&](const SiteGraph& graph) { return has_map(graph, "d"); }},
      {"UpdateMap",
       [&] {
         storage::Map map = *stores_.maps.Get(Soon(), site_, MapId("d"));
         map.level = 3;
         return editor_->UpdateMap(Soon(), map).status();
       },
       [&](const SiteGraph& graph) { return graph.graph().FindMap(MapId("d"))->level == 3; }},
      {"CreateLinkPoint", [&] { return editor_->CreateLinkPoint(Soon(), Candidate(site_, "cd", "c", 7), "").status(); },
       [&](const SiteGraph& graph) { return link_point(graph, "cd") != nullptr; }},
      {"AddAnchor",
       [&] {
         return editor_
             ->AddAnchor(
                 Soon(), site_,
                 {.link_point = LinkPointId("cd"), .anchor = {MapId("d"), {}, graph::DefaultAnchorCovariance()}})
             .status();
       },
       [&](const SiteGraph& graph) { return link_point(graph, "cd")->anchors.size() == 2; }},
      {"UpdateLinkPoint",
       [&] {
         storage::StoredLinkPoint changed = *stores_.link_points.Get(Soon(), site_, LinkPointId("cd"));
         changed.point.tag = "north door";
         return editor_->UpdateLinkPoint(Soon(), changed).status();
       },
       [&](const SiteGraph& graph) { return link_point(graph, "cd")->tag == "north door"; }},
      {"PutEvidence",
       [&] {
         return editor_->PutEvidence(Soon(), site_,
                                     {.link_point = LinkPointId("cd"),
                                      .map = MapId("d"),
                                      .content = {sha256, static_cast<std::int64_t>(content.size())}});
       },
       [&](const SiteGraph& graph) { return link_point(graph, "cd") != nullptr; }},
      {"SetSuspended", [&] { return editor_->SetSuspended(Soon(), site_, LinkPointId("cd"), 0, true).status(); },
       [&](const SiteGraph& graph) { return link_point(graph, "cd")->use == graph::LinkPointUse::kSuspended; }},
      {"SetControlPoints",
       [&] {
         return editor_->SetControlPoints(Soon(), site_, {{MapId("a"), {0, 0}, 48.0, 11.0}}).status();
       },
       [&](const SiteGraph& graph) { return graph.control_points.size() == 1; }},
      {"DeleteLinkPoint", [&] { return editor_->DeleteLinkPoint(Soon(), site_, LinkPointId("cd"), 0); },
       [&](const SiteGraph& graph) { return link_point(graph, "cd") == nullptr; }},
      {"DeleteMap", [&] { return editor_->DeleteMap(Soon(), site_, MapId("d"), 0, false); },
       [&](const SiteGraph& graph) { return !has_map(graph, "d"); }},
  };
  for (const Edit& edit : edits) {
    const auto before = Get();
    ASSERT_OK(edit.make()) << edit.name;
    const auto after = Get();
    EXPECT_EQ(after->graph().version(), Version()) << edit.name;
    EXPECT_TRUE(edit.is_in(*after)) << edit.name;
  }
}

TEST_F(GraphEditorTest, ARefusedEditLeavesTheCachedGraph) {
  const auto before = Get();
  const int reads = probe_.reads();
  EXPECT_CODE(editor_->CreateMap(Soon(), MakeMap(site_, "a"), ""), absl::StatusCode::kAlreadyExists);
  EXPECT_CODE(editor_->DeleteMap(Soon(), site_, MapId("b"), 0, false), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(editor_->DeleteLinkPoint(Soon(), site_, LinkPointId("ab"), 99999), absl::StatusCode::kAborted);
  EXPECT_CODE(editor_->SetSuspended(Soon(), site_, LinkPointId("none"), 0, true), absl::StatusCode::kNotFound);
  EXPECT_EQ(Get(), before);
  EXPECT_EQ(probe_.reads(), reads);
}

// A map store whose commits succeed and whose answers are lost.
class LossyMapStore final : public storage::MapStore {
 public:
  explicit LossyMapStore(const storage::MapStore& store) : store_(store) {}

  absl::StatusOr<storage::Map> Create(const storage::CallContext& context, const storage::Map& map,
                                      const storage::RequestId& request_id) const override {
    EXPECT_OK(store_.Create(context, map, request_id));
    return absl::UnavailableError("the connection was lost during the commit");
  }
  absl::StatusOr<storage::Map> Get(const storage::CallContext& context, const SiteId& site,
                                   const MapId& map) const override {
    return store_.Get(context, site, map);
  }
  absl::StatusOr<storage::Map> GetByDisplayName(const storage::CallContext& context, const SiteId& site,
                                                const std::string& display_name) const override {
    return store_.GetByDisplayName(context, site, display_name);
  }
  absl::StatusOr<std::vector<storage::Map>> List(const storage::CallContext& context, const SiteId& site,
                                                 const storage::PageRequest& page) const override {
    return store_.List(context, site, page);
  }
  absl::StatusOr<storage::Map> Update(const storage::CallContext& context, const storage::Map& map) const override {
    return store_.Update(context, map);
  }
  absl::Status Delete(const storage::CallContext& context, const SiteId& site, const MapId& map, std::int64_t etag,
                      bool force) const override {
    return store_.Delete(context, site, map, etag, force);
  }

 private:
  const storage::MapStore& store_;
};

TEST_F(GraphEditorTest, AnEditOfUnknownOutcomeIsInTheNextAnswerIfItWasCommitted) {
  const LossyMapStore lossy(stores_.maps);
  GraphEditor editor({lossy, stores_.link_points, probe_}, *graphs_);
  EXPECT_CODE(editor.CreateMap(Soon(), MakeMap(site_, "d"), ""), absl::StatusCode::kUnavailable);
  EXPECT_GE(Get()->graph().MapSlot(MapId("d")), 0);
}

}  // namespace
}  // namespace enfilade::server
