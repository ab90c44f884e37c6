// SPDX-License-Identifier: Apache-2.0
#include "core/rearrange/rearrangement.h"

#include <cmath>

#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::rearrange {
namespace {

using ::enfilade::testing::AnchorIn;
using ::enfilade::testing::Joining;
using ::enfilade::testing::L;
using ::enfilade::testing::M;
using ::testing::HasSubstr;

TEST(RearrangementTest, AnEmptyOneIsValidAndEmpty) {
  EXPECT_OK(Validate({}));
  EXPECT_TRUE(Rearrangement{}.empty());
  Rearrangement one;
  one.redirects = {{M("a"), M("b"), {}}};
  EXPECT_FALSE(one.empty());
}

TEST(RearrangementTest, NamesWhatBreaksARule) {
  const auto expect = [](const Rearrangement& wrong, const std::string& message) {
    EXPECT_STATUS(Validate(wrong), absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };
  Rearrangement wrong;
  wrong.moves = {{SessionId("s"), M("a"), {}}, {SessionId("s"), M("b"), {}}};
  expect(wrong, "\"s\" is given twice");
  wrong.moves = {{SessionId("S!"), M("a"), {}}};
  expect(wrong, "not a valid id");
  wrong.moves = {{SessionId("s"), M("a"), {NAN, 0, 0}}};
  expect(wrong, "not finite");
  wrong.moves = {{SessionId("s"), M("a"), {}}};
  wrong.redirects = {{M("a"), M("b"), {}}};
  expect(wrong, "would move into map a");
  wrong.moves.clear();
  wrong.redirects.push_back({M("b"), M("c"), {}});
  expect(wrong, "which disappears itself");
  wrong.redirects.pop_back();
  wrong.link_points = {Joining("l", {AnchorIn("a", {})})};
  expect(wrong, "has an anchor in map a");
  wrong.redirects.clear();
  wrong.removed_link_points = {L("l")};
  expect(wrong, "both stored and removed");
  wrong = {};
  wrong.cuts = {{SessionId("s"), 1, SessionId("r")}};
  expect(wrong, "nothing would be left");
  wrong.cuts = {{SessionId("s"), 2, SessionId("r")}, {SessionId("s"), 2, SessionId("r2")}};
  expect(wrong, "cut twice before record 2");
  wrong.cuts = {{SessionId("s"), 2, SessionId("r")}, {SessionId("s"), 3, SessionId("r")}};
  expect(wrong, "\"r\" is given twice");
  wrong.cuts = {{SessionId("S!"), 2, SessionId("r")}};
  expect(wrong, "not a valid id");
  wrong.cuts = {{SessionId("s"), 2, SessionId("r")}, {SessionId("s"), 3, SessionId("r2")}};
  EXPECT_OK(Validate(wrong));
}

}  // namespace
}  // namespace enfilade::rearrange
