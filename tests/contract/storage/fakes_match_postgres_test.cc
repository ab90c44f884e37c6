// SPDX-License-Identifier: Apache-2.0
// Random sequences of calls against the PostgreSQL stores and the fakes at the same time: both must return the same,
// errors included. Finds what nobody thought of when writing the contract tests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "fmt/format.h"
#include "fmt/ranges.h"
#include "tests/contract/storage/store_values.h"
#include "tests/contract/storage/suite/backend.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

const SiteId kSite("campus");
const RobotId kRobot("r1");

storage::CallContext Soon() { return storage::CallContext::WithTimeout(std::chrono::seconds(60)); }

std::string TextOf(const absl::Status& status) { return absl::StatusCodeToString(status.code()); }

std::string TextOf(const PoseWithCovariance& pose) {
  return fmt::format("({} {} {}; {} {} {})", pose.pose.x, pose.pose.y, pose.pose.yaw, pose.covariance(0, 0),
                     pose.covariance(1, 1), pose.covariance(2, 2));
}

std::string TextOf(const storage::StoredLinkPoint& stored) {
  std::string text = fmt::format("{} v{} use {} {} direction '{}' tag '{}' at {}:", stored.point.id.value(),
                                 stored.point.graph_version, static_cast<int>(stored.point.use),
                                 stored.forced ? "forced" : "", stored.point.direction.value(), stored.point.tag,
                                 stored.T_world_place ? TextOf(*stored.T_world_place) : "nowhere");
  for (const graph::Anchor& anchor : stored.point.anchors) {
    text +=
        fmt::format(" {} {}", anchor.map.value(), TextOf(PoseWithCovariance{anchor.T_map_place, anchor.covariance}));
  }
  return text + "\n";
}

std::string TextOf(const storage::GraphChanges& changes) {
  std::string text = fmt::format("version {} root '{}' {}\n", changes.version, changes.root.value(),
                                 changes.complete ? "complete" : "");
  for (const MapId& map : changes.removed_maps) text += "removed " + map.value() + "\n";
  for (const LinkPointId& id : changes.removed_link_points) text += "removed " + id.value() + "\n";
  for (const storage::GraphMap& map : changes.maps) {
    text += fmt::format("{} '{}' level {} {} corners v{} at {}\n", map.id.value(), map.display_name, map.level,
                        map.outline.size(), map.graph_version, map.T_world_map ? TextOf(*map.T_world_map) : "nowhere");
  }
  for (const storage::StoredLinkPoint& link_point : changes.link_points) text += TextOf(link_point);
  return text;
}

std::string TextOf(const storage::Session& session) {
  const storage::RecordCounts& counts = session.record_counts;
  return fmt::format("{} in '{}' state {} {}/{}/{} counts {} {} {} {} bytes {} times {}..{} mapped {} '{}' {}\n",
                     session.id.value(), session.map ? session.map->value() : "", static_cast<int>(session.state),
                     session.acknowledged_sequence, session.highest_sequence, session.mapped_sequence,
                     counts.laser_scans, counts.odometry, counts.images, counts.withheld, session.payload_bytes,
                     session.first_time.value_or(-1), session.last_time.value_or(-1), session.mapping_counts.used,
                     session.error, session.finish_time.has_value());
}

// Both backends. A call is given as a function of a backend that returns what happened, as text.
class Twins {
 public:
  using Call = std::function<std::string(Backend&)>;

  Twins() {
    for (const auto& backend : backends_) {
      backend->AddSite(kSite);
      backend->AddRobot(kSite, kRobot);
    }
  }

  // What both return; a difference fails the test.
  std::string Run(const std::string& name, const Call& call) {
    const std::string expected = call(*backends_[0]);
    const std::string actual = call(*backends_[1]);
    calls_.push_back(name + " -> " + expected.substr(0, expected.find('\n')));
    EXPECT_EQ(actual, expected) << "in memory, and PostgreSQL, after:\n" << fmt::format("{}", fmt::join(calls_, "\n"));
    return expected;
  }

 private:
  const std::array<std::unique_ptr<Backend>, 2> backends_ = {MakePostgresBackend(), MakeInMemoryBackend()};
  std::vector<std::string> calls_;
};

class FakesMatchPostgresTest : public ::testing::TestWithParam<unsigned> {
 protected:
  std::size_t Random(std::size_t count) { return random_() % count; }
  bool Chance(std::size_t one_in) { return Random(one_in) == 0; }

  MapId RandomMap() { return MapId(fmt::format("m{}", Random(4))); }
  LinkPointId RandomLinkPoint() { return LinkPointId(fmt::format("p{}", Random(8))); }
  // On a coarse lattice, so that link points meet.
  graph::Anchor RandomAnchor(const MapId& map) {
    graph::Anchor anchor =
        MakeAnchor(map.value(), static_cast<double>(Random(3)), 0.2 * static_cast<double>(Random(3)));
    anchor.covariance *= static_cast<double>(1 + Random(20));
    return anchor;
  }
  std::vector<graph::Anchor> RandomAnchors() {
    std::vector<graph::Anchor> anchors;
    for (std::size_t i = 0; i < 4; ++i) {
      if (Chance(2)) anchors.push_back(RandomAnchor(MapId(fmt::format("m{}", i))));
    }
    std::shuffle(anchors.begin(), anchors.end(), random_);
    return anchors;
  }
  // An etag that is the stored one, any, or stale.
  std::function<std::int64_t(Backend&)> RandomEtag(const LinkPointId& id) {
    const std::size_t kind = Random(4);
    return [=](Backend& backend) -> std::int64_t {
      if (kind == 0) return 0;
      const auto stored = backend.link_points().Get(Soon(), kSite, id);
      return (stored.ok() ? stored->etag : 1) + (kind == 1 ? 1'000'000 : 0);
    };
  }

  std::mt19937 random_{GetParam()};
  Twins twins_;
};

std::string Outcome(const absl::StatusOr<storage::StoredLinkPoint>& changed) {
  return changed.ok() ? TextOf(*changed) : TextOf(changed.status());
}

TEST_P(FakesMatchPostgresTest, WhateverIsDoneToAGraph) {
  const auto create_map = [&](const MapId& map) {
    return [=](Backend& backend) {
      return TextOf(backend.maps().Create(Soon(), MakeMap(kSite, map, map.value()), "").status());
    };
  };
  for (const char* map : {"m0", "m1", "m2"}) twins_.Run(std::string("create ") + map, create_map(MapId(map)));
  std::int64_t since = 0;
  for (int step = 0; step < 70 && !HasFailure(); ++step) {
    const MapId map = RandomMap();
    const LinkPointId id = RandomLinkPoint();
    const auto etag = RandomEtag(id);
    const bool flag = Chance(3);
    switch (Random(12)) {
      case 0:
        twins_.Run("create map " + map.value(), create_map(map));
        break;
      case 1: {
        const int level = static_cast<int>(Random(3));
        twins_.Run("update map " + map.value(), [&](Backend& backend) {
          auto stored = backend.maps().Get(Soon(), kSite, map);
          if (!stored.ok()) return TextOf(stored.status());
          stored->level = level;
          stored->outline =
              flag ? std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}, {0, 1}} : std::vector<Eigen::Vector2d>{};
          return TextOf(backend.maps().Update(Soon(), *stored).status());
        });
        break;
      }
      case 2:
        if (!Chance(3)) break;
        twins_.Run(fmt::format("delete map {} {}", map.value(), flag ? "by force" : ""),
                   [&](Backend& backend) { return TextOf(backend.maps().Delete(Soon(), kSite, map, 0, flag)); });
        break;
      case 3:
      case 4:
      case 5: {
        storage::StoredLinkPoint link_point = MakeLinkPoint(kSite, id.value(), RandomAnchors());
        link_point.forced = flag;
        if (Chance(3)) link_point.point.direction = map;
        twins_.Run("create " + id.value(),
                   [&](Backend& backend) { return Outcome(backend.link_points().Create(Soon(), link_point, "")); });
        break;
      }
      case 6:
      case 7: {
        const graph::Anchor anchor = RandomAnchor(map);
        twins_.Run(fmt::format("add {} to {}", map.value(), id.value()), [&](Backend& backend) {
          return Outcome(backend.link_points().AddAnchor(Soon(), kSite, {id, etag(backend), anchor, flag}));
        });
        break;
      }
      case 8: {
        const std::vector<graph::Anchor> anchors = RandomAnchors();
        const bool move = Chance(2);
        twins_.Run("update " + id.value(), [&](Backend& backend) {
          auto stored = backend.link_points().Get(Soon(), kSite, id);
          storage::StoredLinkPoint changed = stored.ok() ? *stored : MakeLinkPoint(kSite, id.value(), anchors);
          changed.etag = etag(backend);
          changed.forced = flag;
          changed.point.tag = fmt::format("step {}", step);
          if (move && !changed.point.anchors.empty()) changed.point.anchors.front().T_map_place.x += 0.25;
          if (!move && !anchors.empty()) changed.point.anchors = anchors;
          return Outcome(backend.link_points().Update(Soon(), changed));
        });
        break;
      }
      case 9:
        twins_.Run(fmt::format("{} {}", flag ? "resume" : "suspend", id.value()), [&](Backend& backend) {
          return Outcome(backend.link_points().SetSuspended(Soon(), kSite, id, etag(backend), !flag));
        });
        break;
      case 10:
        twins_.Run("delete " + id.value(), [&](Backend& backend) {
          return TextOf(backend.link_points().Delete(Soon(), kSite, id, etag(backend)));
        });
        break;
      default: {
        storage::GraphSolution solution;
        solution.maps = {{map, {{1.0 * step, 2.0, 0.5}, Eigen::Matrix3d::Identity()}}};
        solution.link_points = {{id, {{2.0 * step, 1.0, 0.5}, Eigen::Matrix3d::Identity()}}};
        if (flag) solution.switched_off = {id, RandomLinkPoint()};
        solution.complete = Chance(3);
        if (!solution.complete && map != MapId("m2")) solution.unposed = {MapId("m2")};
        const std::int64_t stale = Chance(4) ? 1 : 0;
        twins_.Run("solve", [&](Backend& backend) {
          const std::int64_t version = *backend.graphs().GetVersion(Soon(), kSite) - stale;
          const auto applied = backend.graphs().Apply(Soon(), kSite, version, solution);
          return applied.ok() ? fmt::format("version {}", *applied) : TextOf(applied.status());
        });
        break;
      }
    }
    twins_.Run("read all", [&](Backend& backend) { return TextOf(*backend.graphs().ReadChanges(Soon(), kSite, 0)); });
    twins_.Run(fmt::format("read since {}", since),
               [&](Backend& backend) { return TextOf(*backend.graphs().ReadChanges(Soon(), kSite, since)); });
    if (Chance(5)) {
      twins_.Run("version", [&](Backend& backend) {
        since = *backend.graphs().GetVersion(Soon(), kSite);
        return std::to_string(since);
      });
    }
  }
  storage::LinkPointQuery query;
  query.area = storage::LinkPointCircle{{0, 0}, std::numeric_limits<double>::infinity()};
  for (const std::optional<int>& level : {std::optional<int>(), std::optional<int>(0), std::optional<int>(2)}) {
    query.level = level;
    twins_.Run("find", [&](Backend& backend) {
      std::string found;
      const auto result = backend.link_points().Find(Soon(), kSite, query);
      for (const auto& link_point : result->link_points) {
        found += TextOf(link_point);
      }
      return found;
    });
  }
  twins_.Run("history", [](Backend& backend) {
    std::string history;
    const auto versions = backend.graphs().ListVersions(Soon(), kSite, 0, 1000);
    for (const storage::GraphVersion& version : *versions) {
      history += fmt::format("{} {} {} {}\n", version.version, static_cast<int>(version.cause), version.resource,
                             version.optimization ? version.optimization->map_count : -1);
    }
    return history;
  });
}

TEST_P(FakesMatchPostgresTest, WhateverIsDoneToSessionsAndTheirMapping) {
  twins_.Run("map", [](Backend& backend) {
    return TextOf(backend.maps().Create(Soon(), MakeMap(kSite, MapId("m0"), "m0"), "").status());
  });
  const TestBlob image("image");
  std::vector<std::array<storage::SessionLease, 2>> leases;
  for (int step = 0; step < 80 && !HasFailure(); ++step) {
    const SessionId session(fmt::format("s{}", Random(4)));
    const auto first = static_cast<std::int64_t>(1 + Random(12));
    const auto count = static_cast<std::int64_t>(Random(5));
    const std::size_t kind = Random(12);
    switch (kind) {
      case 0:
      case 1: {
        const auto map = Chance(4) ? std::nullopt : std::optional<MapId>("m0");
        twins_.Run("create " + session.value(), [&](Backend& backend) {
          return TextOf(backend.sessions().Create(Soon(), MakeSession(kSite, session, kRobot, map), "").status());
        });
        break;
      }
      case 2:
      case 3:
      case 4:
      case 5: {
        std::vector<sensor::Record> records;
        for (std::int64_t sequence = first; sequence < first + count; ++sequence) {
          records.push_back(sequence % 5 == 0 ? ImageRecord(sequence, image.ref()) : ScanRecord(sequence));
        }
        if (!records.empty() && Chance(6)) records.back() = OdometryRecord(records.back().sequence);
        const std::vector<storage::BlobView> blobs = {image.view()};
        const bool with_blob = Chance(2);
        twins_.Run(fmt::format("append {}+{} to {}", first, count, session.value()), [&](Backend& backend) {
          const storage::RecordBatch batch{
              kSite, session, records, with_blob ? absl::MakeConstSpan(blobs) : absl::Span<const storage::BlobView>()};
          const auto result = backend.records().Append(Soon(), batch);
          if (!result.ok()) {
            return fmt::format("{} {}", TextOf(result.status()), storage::RefusedSequenceOf(result.status()));
          }
          return fmt::format("{} {} {}", result->acknowledged_sequence, result->inserted, result->duplicates);
        });
        break;
      }
      case 6: {
        const bool any = Chance(3);
        twins_.Run("finish " + session.value(), [&](Backend& backend) {
          const auto stored = backend.sessions().Get(Soon(), kSite, session);
          const std::int64_t last = stored.ok() && !any ? stored->highest_sequence : first;
          return TextOf(backend.sessions().Finish(Soon(), kSite, session, last).status());
        });
        break;
      }
      case 7:
        if (!Chance(4)) break;
        twins_.Run("delete " + session.value(),
                   [&](Backend& backend) { return TextOf(backend.sessions().Delete(Soon(), kSite, session)); });
        break;
      case 8: {
        std::array<storage::SessionLease, 2> held;
        std::size_t twin = 0;
        const std::string acquired = twins_.Run("acquire", [&](Backend& backend) {
          const auto leased = backend.mappings().Acquire(Soon(), "worker", std::chrono::seconds(600));
          if (!leased.ok() || !*leased) return std::string("nothing");
          held[twin++] = (*leased)->lease;
          return fmt::format("{} {}", (*leased)->lease.token, TextOf((*leased)->session));
        });
        if (acquired != "nothing") leases.push_back(held);
        break;
      }
      default: {
        if (leases.empty()) break;
        const std::array<storage::SessionLease, 2> held = leases[Random(leases.size())];
        std::size_t twin = 0;
        if (kind == 9) {
          twins_.Run("release " + held[0].session.value(),
                     [&](Backend& backend) { return TextOf(backend.mappings().Release(Soon(), held[twin++], 0)); });
          break;
        }
        slam::SlamDelta delta;
        if (Chance(2)) delta.submaps = {{0, first, {0, 0, 0}, false, Chance(2) ? "content" : ""}};
        if (Chance(2))
          delta.nodes = {{count, first, first * kNsPerSecond, {1.0 * step, 0, 0}, Eigen::Matrix3d::Identity(), 0}};
        if (Chance(3)) delta.trajectory = {{first, first * kNsPerSecond, count, {0.5, 0, 0}}};
        storage::MappingStep mapping = StepOf(delta, "checkpoint", first);
        mapping.counts.used = step;
        if (Chance(4))
          mapping.final_state = Chance(3) ? storage::SessionState::kFailed : storage::SessionState::kMapped;
        mapping.error = "error";
        twins_.Run(fmt::format("commit {} to {}", first, held[0].session.value()), [&](Backend& backend) {
          const auto committed = backend.mappings().Commit(Soon(), held[twin++], mapping);
          return committed.ok() ? std::to_string(*committed) : TextOf(committed.status());
        });
        break;
      }
    }
    twins_.Run("sessions", [](Backend& backend) {
      std::string text;
      const auto sessions = backend.sessions().List(Soon(), kSite, {}, 100, std::nullopt);
      for (const storage::Session& stored : *sessions) {
        text += TextOf(stored);
        const auto records = backend.records().Read(Soon(), kSite, stored.id, 1, 1 << 20);
        text += records.ok() ? fmt::format("{} records", records->size()) : TextOf(records.status());
        const auto mapping = backend.mappings().Load(Soon(), kSite, stored.id);
        if (!mapping.ok() || !*mapping) continue;
        text += fmt::format(" mapping {} {}:", (*mapping)->mapped_sequence, (*mapping)->checkpoint);
        for (const auto& [id, submap] : (*mapping)->map.submaps) {
          text += fmt::format(" submap {} {} {}", id, submap.version, submap.content);
        }
        for (const auto& [id, node] : (*mapping)->map.nodes) text += fmt::format(" node {} {}", id, node.T_map_node.x);
        for (const auto& point : (*mapping)->map.trajectory) {
          text += fmt::format(" point {} {} {}", point.sequence, point.node, point.time);
        }
        const auto trajectory = backend.mappings().ReadTrajectory(Soon(), kSite, stored.id);
        for (const auto& pose : trajectory->poses) text += fmt::format(" pose {}", pose.T_map_robot.x);
      }
      return text;
    });
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, FakesMatchPostgresTest, ::testing::Range(1U, 7U));

}  // namespace
}  // namespace enfilade::testing
