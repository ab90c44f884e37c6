// SPDX-License-Identifier: Apache-2.0
// `enfilade map publish` and `enfilade map rebase`.
#include <algorithm>
#include <iostream>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/edit/draft_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

struct PublishCommandOptions {
  std::string map;
  std::string draft;
  std::string message;
  bool confirm = false;
  bool dry_run = false;
  std::vector<std::string> mine;
  std::vector<std::string> theirs;
};

struct CheckedDraft {
  v1::MapDraft draft;
  v1::CheckMapDraftResponse check;
};

absl::StatusOr<CheckedDraft> CheckDraft(const client::Connection& connection, const std::string& name) {
  CheckedDraft checked;
  v1::GetMapDraftRequest get;
  get.set_name(name);
  ENFILADE_ASSIGN_OR_RETURN(const auto found, connection.Call(&v1::MapEditService::Stub::GetMapDraft, get));
  checked.draft = found.draft();
  v1::CheckMapDraftRequest check;
  check.set_name(name);
  ENFILADE_ASSIGN_OR_RETURN(checked.check, connection.Call(&v1::MapEditService::Stub::CheckMapDraft, check));
  return checked;
}

// The name of a conflict on the command line: its first cell.
std::string ConflictName(const v1::MapEditConflict& conflict) {
  return fmt::format("{},{}", conflict.box().first_column(), conflict.box().first_row());
}

std::string SeverityText(const v1::MapEditProblem& problem) {
  return problem.severity() == v1::MapEditProblem::SEVERITY_ERROR ? "error" : "warning";
}

nlohmann::json CheckToJson(const v1::CheckMapDraftResponse& check) {
  nlohmann::json document{{"changes", ChangesToJson(check.changes())},
                          {"edit_version", check.edit_version()},
                          {"head", check.head()},
                          {"problems", nlohmann::json::array()},
                          {"conflicts", nlohmann::json::array()}};
  if (check.has_box()) document["box"] = BoxToJson(check.box());
  for (const v1::MapEditProblem& problem : check.problems()) {
    document["problems"].push_back({{"severity", SeverityText(problem)}, {"message", problem.message()}});
    if (problem.has_box()) document["problems"].back()["box"] = BoxToJson(problem.box());
  }
  for (const v1::MapEditConflict& conflict : check.conflicts()) {
    document["conflicts"].push_back(
        {{"conflict", ConflictName(conflict)},
         {"box", BoxToJson(conflict.box())},
         {"cells", conflict.cells()},
         {"mine", std::vector<std::string>(conflict.my_authors().begin(), conflict.my_authors().end())},
         {"theirs", std::vector<std::string>(conflict.their_authors().begin(), conflict.their_authors().end())}});
  }
  return document;
}

void PrintCheck(const CheckedDraft& checked) {
  const edit::Lattice lattice = LatticeOf(checked.draft.lattice());
  std::cout << ChangesText(checked.check.changes());
  if (checked.check.has_box()) std::cout << ", within " << PlaceText(checked.check.box(), lattice);
  std::cout << '\n';
  for (const v1::MapEditProblem& problem : checked.check.problems()) {
    std::cout << SeverityText(problem) << ": " << problem.message();
    if (problem.has_box()) std::cout << " (" << PlaceText(problem.box(), lattice) << ')';
    std::cout << '\n';
  }
  for (const v1::MapEditConflict& conflict : checked.check.conflicts()) {
    std::cout << "conflict " << ConflictName(conflict) << ": " << PeopleText(conflict.my_authors()) << " and "
              << PeopleText(conflict.their_authors()) << " say different things of " << conflict.cells() << " cells, "
              << PlaceText(conflict.box(), lattice) << '\n';
  }
}

// What would hinder publishing.
absl::Status Hindrance(const v1::CheckMapDraftResponse& check, bool confirm) {
  if (check.conflicts_size() > 0) {
    return FailedPrecondition("{} conflicts with what others have published: settle them by enfilade map rebase",
                              check.conflicts_size());
  }
  for (const v1::MapEditProblem& problem : check.problems()) {
    if (problem.severity() == v1::MapEditProblem::SEVERITY_ERROR)
      return FailedPrecondition("cannot be published: {}", problem.message());
  }
  if (check.problems_size() > 0 && !confirm)
    return FailedPrecondition("there are warnings: publish with --confirm, or change the draft");
  return absl::OkStatus();
}

absl::Status TryPublish(const Globals& globals, const client::Connection& connection, const std::string& name,
                        bool confirm) {
  ENFILADE_ASSIGN_OR_RETURN(const CheckedDraft checked, CheckDraft(connection, name));
  absl::Status hindrance = Hindrance(checked.check, confirm);
  if (globals.json) {
    nlohmann::json document = CheckToJson(checked.check);
    document["can_publish"] = hindrance.ok();
    PrintJson(std::cout, document);
  } else {
    PrintCheck(checked);
    if (hindrance.ok()) std::cout << "it can be published\n";
  }
  return hindrance;
}

absl::Status PublishDraft(const Globals& globals, const PublishCommandOptions& options) {
  if (options.message.empty() && !options.dry_run)
    return InvalidArgument("--message is missing: say what was edited and why");
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const std::string name, FindDraftName(connection, globals, options.map, options.draft));
  if (options.dry_run) return TryPublish(globals, connection, name, options.confirm);
  v1::PublishMapDraftRequest request;
  request.set_name(name);
  request.set_message(options.message);
  request.set_confirm_warnings(options.confirm);
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapEditService::Stub::PublishMapDraft, request));
  if (globals.json) {
    PrintJson(std::cout, {{"revision", response.revision().name()},
                          {"edit_version", response.draft().edit_version()},
                          {"changes", ChangesToJson(response.changes())},
                          {"merged_publications", response.merged_publications()}});
    return absl::OkStatus();
  }
  std::cout << response.revision().name() << ": " << ChangesText(response.changes()) << '\n';
  if (response.merged_publications() > 0) {
    std::cout << "merged with " << response.merged_publications()
              << " publications of others since the draft began, without a conflict\n";
  }
  return absl::OkStatus();
}

bool IsNamed(const std::vector<std::string>& names, const v1::MapEditConflict& conflict) {
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return name == "all" || name == ConflictName(conflict); });
}

absl::Status CheckNames(const std::vector<std::string>& names, const v1::CheckMapDraftResponse& check) {
  for (const std::string& name : names) {
    const bool is_known =
        name == "all" || std::any_of(check.conflicts().begin(), check.conflicts().end(),
                                     [&](const auto& conflict) { return ConflictName(conflict) == name; });
    if (!is_known) {
      return NotFound("no conflict \"{}\": enfilade map publish --dry-run lists them", name);
    }
  }
  return absl::OkStatus();
}

absl::Status RebaseDraft(const Globals& globals, const PublishCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const std::string name, FindDraftName(connection, globals, options.map, options.draft));
  ENFILADE_ASSIGN_OR_RETURN(const CheckedDraft checked, CheckDraft(connection, name));
  ENFILADE_RETURN_IF_ERROR(CheckNames(options.mine, checked.check));
  ENFILADE_RETURN_IF_ERROR(CheckNames(options.theirs, checked.check));
  v1::RebaseMapDraftRequest request;
  request.set_name(name);
  request.set_edit_version(checked.check.edit_version());
  for (const v1::MapEditConflict& conflict : checked.check.conflicts()) {
    const bool is_mine = IsNamed(options.mine, conflict);
    if (is_mine && IsNamed(options.theirs, conflict)) {
      return InvalidArgument("conflict {} is given to --mine and to --theirs: choose one", ConflictName(conflict));
    }
    if (!is_mine && !IsNamed(options.theirs, conflict)) continue;
    v1::MapEditResolution& resolution = *request.add_resolutions();
    *resolution.mutable_box() = conflict.box();
    resolution.set_choice(is_mine ? v1::MapEditResolution::CHOICE_MINE : v1::MapEditResolution::CHOICE_THEIRS);
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapEditService::Stub::RebaseMapDraft, request));
  if (globals.json) {
    PrintJson(std::cout, DraftToJson(response.draft()));
  } else {
    std::cout << name << " lies over publication " << response.draft().base_edit_version() << "; "
              << request.resolutions_size() << " conflicts settled\n";
  }
  return absl::OkStatus();
}

void AddPublishArguments(CLI::App& command, const std::shared_ptr<PublishCommandOptions>& options) {
  command.add_option("MAP", options->map, "The map's name, id or resource name")->required();
  command.add_option("DRAFT", options->draft, "The draft's id or resource name")->required();
}

}  // namespace

void AddMapPublish(CLI::App& map, const Globals& globals) {
  const auto options = std::make_shared<PublishCommandOptions>();
  CLI::App* publish = AddCommand(map, "publish", "Make a draft the map's next revision",
                                 [&globals, options] { return PublishDraft(globals, *options); });
  AddPublishArguments(*publish, options);
  publish->add_option("-m,--message", options->message, "What was edited and why, at most 500 characters");
  publish->add_flag("--confirm", options->confirm, "Publish in spite of warnings");
  publish->add_flag("--dry-run", options->dry_run,
                    "Only say what would change, and what speaks against it; fails if it could not be published");
  publish->footer(
      "Examples: enfilade map publish \"Main hall\" glass --dry-run\n"
      "          enfilade map publish \"Main hall\" glass --message \"Glass walls of the meeting rooms\"");

  CLI::App* rebase = AddCommand(map, "rebase", "Put a draft over what others have published since it began",
                                [&globals, options] { return RebaseDraft(globals, *options); });
  AddPublishArguments(*rebase, options);
  rebase->add_option("--mine", options->mine, "Conflicts in which the draft holds: COLUMN,ROW, or all");
  rebase->add_option("--theirs", options->theirs, "Conflicts in which what is published holds: COLUMN,ROW, or all");
  rebase->footer(
      "Conflicts are listed by enfilade map publish --dry-run.\n"
      "Example: enfilade map rebase \"Main hall\" glass --mine 120,-4 --theirs 180,22");
}

}  // namespace enfilade::cli
