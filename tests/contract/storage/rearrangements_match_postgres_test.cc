// SPDX-License-Identifier: Apache-2.0
// Random rearrangements in PostgreSQL and in memory at the same time: both must return the same and end in the same.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "tests/contract/storage/suite/contract_stores.h"
#include "tests/contract/storage/suite/rearrangement_fixture.h"

namespace enfilade::testing {
namespace {

template <std::unique_ptr<Backend> (*kMake)()>
class StoresMadeBy : protected ContractStores {
 protected:
  StoresMadeBy() : ContractStores(kMake()) {}
};

// Numbers as both compute them, to a millionth.
std::string Rounded(const std::string& text) {
  static const std::regex kNumber("-?[0-9]+(\\.[0-9]+)?(e-?[0-9]+)?");
  std::string rounded;
  auto end = text.cbegin();
  for (std::sregex_iterator match(text.begin(), text.end(), kNumber), none; match != none; ++match) {
    rounded.append(end, (*match)[0].first);
    const std::string number = fmt::format("{:.6f}", std::strtod(match->str().c_str(), nullptr));
    rounded += number == "-0.000000" ? "0.000000" : number;
    end = (*match)[0].second;
  }
  return rounded.append(end, text.cend());
}

// The fixture's site in one backend, and what may be done to it; each returns what the stores did, as text.
template <std::unique_ptr<Backend> (*kMake)()>
class RearrangedTwin : public RearrangementFixture<StoresMadeBy<kMake>> {
  using Fixture = RearrangementFixture<StoresMadeBy<kMake>>;
  using Fixture::Append, Fixture::Soon;
  using Fixture::lease_, Fixture::link_points_, Fixture::rearrangements_, Fixture::robot_poses_, Fixture::sessions_,
      Fixture::site_;

 public:
  std::string Merge(const std::string& id) { return Apply(Fixture::Merge(id)); }
  std::string Split(const std::string& id, const std::string& map) {
    storage::RearrangementChange change = Fixture::Split();
    change.id = rearrange::RearrangementId(id);
    rearrange::Rearrangement& split = change.rearrangement;
    split.new_maps[0].id = split.moves[0].to = split.link_points[0].anchors[1].map = change.rasters[0].map = MapId(map);
    split.link_points[0].id = LinkPointId("arch-" + id);
    return Apply(change);
  }
  std::string Cut(const std::string& id, const std::string& map, std::int64_t first_sequence) {
    storage::RearrangementChange change = Fixture::Cut(first_sequence);
    change.id = rearrange::RearrangementId(id);
    rearrange::Rearrangement& cut = change.rearrangement;
    cut.cuts[0].rest = cut.moves[0].session = SessionId("rest-" + id);
    change.rasters[0].entering[0].session = change.rasters[0].revision->session = cut.cuts[0].rest;
    cut.new_maps[0].id = cut.moves[0].to = change.rasters[0].map = MapId(map);
    return Apply(change);
  }
  std::string Undo(const std::string& id) {
    return Text(rearrangements_.Undo(Soon(), lease_, rearrange::RearrangementId(id)));
  }
  std::string Tag(const std::string& link_point, const std::string& tag) {
    auto stored = link_points_.Get(Soon(), site_, LinkPointId(link_point));
    if (!stored.ok()) return absl::StatusCodeToString(stored.status().code());
    stored->point.tag = tag;
    return absl::StatusCodeToString(link_points_.Update(Soon(), *stored).status().code());
  }
  std::string Report(const std::string& map, TimeNs time) {
    const storage::RobotPose pose{
        site_, Fixture::robot_, MapId(map), Fixture::s2_, {{0.5, 0.25, 0.125}, Eigen::Matrix3d::Identity()}, time, 0};
    return absl::StatusCodeToString(robot_poses_.Report(Soon(), pose).code());
  }
  std::string Record(const std::string& session, const std::string& map) {
    const auto created =
        sessions_.Create(Soon(), MakeSession(site_, SessionId(session), Fixture::robot_, MapId(map)), "");
    return absl::StatusCodeToString(created.status().code());
  }
  std::string Read() {
    std::string text = Rounded(Fixture::Everything());
    for (const char* map : {"hall", "lab", "annex"}) {
      const auto redirect = rearrangements_.Resolve(Soon(), site_, MapId(map));
      text += fmt::format("{} leads to {}\n", map, redirect.ok() ? redirect->to.value() : "?");
    }
    const auto listed = rearrangements_.List(Soon(), site_, 0, 100);
    if (!listed.ok()) return text;
    for (const auto& one : *listed) text += Text(absl::StatusOr<storage::StoredRearrangement>(one)) + "\n";
    return text;
  }

 private:
  std::string Apply(const storage::RearrangementChange& change) {
    return Text(rearrangements_.Apply(Soon(), lease_, change));
  }
  // Errors with their messages, which come from the same rules, but for what constraints of the schema say.
  static std::string Text(const absl::StatusOr<storage::StoredRearrangement>& done) {
    if (absl::IsAlreadyExists(done.status())) return "an id is taken";
    if (!done.ok()) return done.status().ToString().substr(0, done.status().ToString().find(" ["));
    std::string text = fmt::format("{} {} to {}, undone {}:", done->id.value(), done->version_before,
                                   done->version_after, done->version_undone);
    for (const auto& cut : done->cuts) text += fmt::format(" cut {} at {}", cut.session.value(), cut.first_sequence);
    for (const auto& move : done->moves) text += fmt::format(" {} to {}", move.session.value(), move.to.value());
    for (const auto& redirect : done->redirects) text += fmt::format(" {} gone", redirect.from.value());
    return text;
  }
};

class RearrangementsMatchPostgresTest : public ::testing::TestWithParam<unsigned> {
 protected:
  template <typename Call>
  void Both(const std::string& name, const Call& call) {
    calls_ += name + "\n";
    const std::string expected = call(postgres_);
    EXPECT_EQ(call(in_memory_), expected) << "in memory, and PostgreSQL, after:\n" << calls_;
  }

  std::mt19937 random_{GetParam()};
  RearrangedTwin<MakePostgresBackend> postgres_;
  RearrangedTwin<MakeInMemoryBackend> in_memory_;
  std::string calls_;
};

TEST_P(RearrangementsMatchPostgresTest, WhateverIsDone) {
  std::vector<std::string> ids;
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random_() % n); };
  for (int step = 0; step < 25 && !HasFailure(); ++step) {
    const std::string id = fmt::format("r{}", step), map = below(4) == 0 ? "annex" : "annex-" + id;
    const std::string old = ids.empty() ? "none" : ids[ids.size() - 1 - below(std::min<std::size_t>(ids.size(), 2))];
    const std::size_t kind = below(10);
    if (kind < 5) ids.push_back(id);
    const auto sequence = static_cast<std::int64_t>(2 + below(3));
    if (kind < 2) Both("merge " + id, [&](auto& twin) { return twin.Merge(id); });
    if (kind == 2 || kind == 3) Both("split " + id, [&](auto& twin) { return twin.Split(id, map); });
    if (kind == 4) Both("cut " + id, [&](auto& twin) { return twin.Cut(id, map, sequence); });
    if (kind == 5 || kind == 6 || kind == 7) Both("undo " + old, [&](auto& twin) { return twin.Undo(old); });
    if (kind == 8) Both("report", [&](auto& twin) { return twin.Report(step % 2 == 0 ? "lab" : map, 1000 + step); });
    if (kind == 9 && step % 3 == 0) Both("tag", [&](auto& twin) { return twin.Tag("seen", id); });
    if (kind == 9 && step % 3 == 1) Both("record", [&](auto& twin) { return twin.Record("late-" + id, map); });
    Both("read", [&](auto& twin) { return twin.Read(); });
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RearrangementsMatchPostgresTest, ::testing::Range(1U, 13U));

}  // namespace
}  // namespace enfilade::testing
