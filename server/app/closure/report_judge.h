// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/graph/site_graph.h"

namespace enfilade::server {

// Makes up its mind about one door report by one version of the site's graph: reads what the session saw, compares it
// with what the graph knows (core/closure decides), and says what is to be stored. Writes nothing but features of
// images. One for each report and graph.
class ReportJudge {
 public:
  // `go_on` is asked between comparisons: an error ends the judgement with it (the lease is lost).
  ReportJudge(const DoorClosureStores& stores, const closure::DoorClosureOptions& options,
              std::shared_ptr<const SiteGraph> graph, std::function<absl::Status()> go_on);

  // What comes of a report; where it is too early to say, what is waited for, and nothing is to be stored.
  struct Judgement {
    storage::DoorChange change;
    std::string wait_for;
  };
  // `waited`: s, since it was too early for the first time. `excluded`: candidates that would make a redundant link
  // point. A report that cannot be judged has a verdict that says so; errors are the stores'. `context` is read anew
  // for each call of a store: go_on may put its deadline off.
  absl::StatusOr<Judgement> Judge(const storage::CallContext& context, const storage::Session& session,
                                  const storage::StoredDoorReport& report, const std::set<LinkPointId>& excluded,
                                  double waited) const;

 private:
  const DoorClosureStores& stores_;
  const closure::DoorClosureOptions& options_;
  const std::shared_ptr<const SiteGraph> graph_;
  const std::function<absl::Status()> go_on_;
};

// A map that begins where the report's robot is; `from`: the map that it comes from, where there is one.
storage::NewMap MapBehind(const std::optional<storage::Map>& from, const sensor::DoorReport* report,
                          const closure::DoorClosureOptions& options);

}  // namespace enfilade::server
