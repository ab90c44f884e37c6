// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>

#include "client/simulator/campus/campus.h"
#include "client/simulator/route_driver.h"
#include "client/simulator/world/world.h"
#include "tests/support/status_assertions.h"

// What the tests of the generators of buildings have in common.
namespace enfilade::simulator {

inline void ExpectDoorsBetweenTwoAreas(const Campus& campus) {
  for (const Door& door : campus.doors) {
    const Eigen::Vector2d along = (door.b - door.a).normalized();
    const Eigen::Vector2d aside = 0.3 * Eigen::Vector2d(-along.y(), along.x());
    const Area* one = campus.AreaAt("ground", door.middle() + aside);
    const Area* other = campus.AreaAt("ground", door.middle() - aside);
    ASSERT_TRUE(one && other) << door.id;
    EXPECT_NE(one, other) << door.id;
  }
}

// The first robot drives its route: through at least half of the areas, `main_area` among them, and back.
inline void ExpectATourThroughMostAreas(const Campus& campus, const std::string& main_area) {
  const auto world = std::make_shared<const World>(campus);
  RouteDriver driver(world, campus.robots.at(0), {}, 0.05);
  std::set<std::string> entered;
  const Eigen::Vector2d start = driver.T_campus_robot().translation();
  while (true) {
    const auto step = driver.Next();
    ASSERT_OK(step);
    if (!*step) break;
    const Area* here = campus.AreaAt("ground", driver.T_campus_robot().translation());
    if (here) entered.insert(here->id);
  }
  EXPECT_TRUE(entered.contains(main_area));
  EXPECT_GE(2 * entered.size(), campus.areas.size());
  EXPECT_LT((driver.T_campus_robot().translation() - start).norm(), 0.5);
}

}  // namespace enfilade::simulator
