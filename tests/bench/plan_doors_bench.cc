// SPDX-License-Identifier: Apache-2.0
// Which doors of plans join two maps, in buildings of two halves (plan_bench/two_halves.py).
//   bench_plan_doors SEED=CAMPUS_FILE...
// Robots "west" and "east" map their halves, each from a map of its own on. A plan of the building, drawn wrong with
// the seed, is aligned by itself and put to use. Prints a JSON line for each building: what became of the plan; of each
// link point that it made where that is in the campus, m, how far the transform between its two maps is off there, m
// and rad, and the reason; and of each door of the plan that robots have seen, and that has no link point, what is
// known of it.
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "nlohmann/json.hpp"
#include "server/app/priors/plan_doors.h"
#include "server/app/priors/plans_beside.h"
#include "tests/contract/closure/plan_doors_fixture.h"

namespace enfilade::testing {
namespace {

class PlanDoorsBench : public PlanDoorsFixture {
 public:
  nlohmann::json Measure(std::uint64_t seed, const std::string& campus) {
    nlohmann::json found = {{"seed", seed}};
    MapBothHalves(campus);
    ImportPlan({.seed = seed});
    const storage::PriorMapOutcome outcome = Activate();
    found["accepted"] = outcome.alignment.has_value();
    found["reason"] = outcome.reason;
    if (!outcome.alignment) return found;
    found["maps"] = Graph()->graph().map_count();
    found["maps_of_plan"] = outcome.alignment->maps.size();
    while (Join() > 0) {
    }
    found["joins"] = Joins();
    found["undecided"] = Undecided();
    return found;
  }

 private:
  void TestBody() override {}

  nlohmann::json Joins() {
    nlohmann::json joins = nlohmann::json::array();
    const auto made = joins_.List(Soon(), site_);
    EXPECT_OK(made);
    const auto graph = Graph();
    for (const storage::PlanJoin& join : *made) {
      const graph::LinkPoint* link_point = graph->graph().FindLinkPoint(join.link_point);
      const Pose2 here = InCampus(link_point->anchors[0]);
      const Pose2 off = Between(here, InCampus(link_point->anchors[1]));
      joins.push_back({{"x", here.x},
                       {"y", here.y},
                       {"error_m", off.translation().norm()},
                       {"error_rad", std::abs(off.yaw)},
                       {"reason", join.reason}});
    }
    return joins;
  }

  nlohmann::json Undecided() {
    nlohmann::json doors = nlohmann::json::array();
    const auto ties = server::ReadTies(Soon(), prior_maps_, blobs_, site_, plan_);
    EXPECT_OK(ties);
    const auto plan = server::ReadPlanDoors(Soon(), prior_maps_, blobs_, site_, plan_, **ties);
    EXPECT_OK(plan);
    for (const closure::SightedDoor& door : closure::FindSightedDoors(*plan, Graph()->graph(), options_)) {
      if (door.state == closure::SightedDoor::State::kNotSighted || door.state == closure::SightedDoor::State::kKnown) {
        continue;
      }
      doors.push_back(door.reason);
    }
    return doors;
  }
};

int Run(const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    const std::size_t equals = argument.find('=');
    std::ifstream in(argument.substr(equals + 1), std::ios::binary);
    const std::string campus{std::istreambuf_iterator<char>(in), {}};
    PlanDoorsBench building;
    std::cout << building.Measure(std::stoull(argument.substr(0, equals)), campus).dump() << std::endl;
  }
  return 0;
}

}  // namespace
}  // namespace enfilade::testing

int main(int argc, char** argv) { return enfilade::testing::Run({argv + 1, argv + argc}); }
