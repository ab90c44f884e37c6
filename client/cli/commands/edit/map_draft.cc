// SPDX-License-Identifier: Apache-2.0
// `enfilade map draft`.
#include <iostream>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/edit/draft_output.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "google/protobuf/util/json_util.h"

namespace enfilade::cli {
namespace {

struct DraftCommandOptions {
  std::string map;
  std::string draft;
  std::string name;
  bool with_published = false;
  std::vector<std::string> edits;
  bool others = false;
};

absl::Status CreateDraft(const Globals& globals, const DraftCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::CreateMapDraftRequest request;
  request.set_parent(map.name());
  request.set_draft_id(options.draft);
  request.mutable_draft()->set_display_name(options.name);
  request.set_request_id(NewUuid());
  ENFILADE_ASSIGN_OR_RETURN(const auto response, connection.Call(&v1::MapEditService::Stub::CreateMapDraft, request));
  if (globals.json) {
    PrintJson(std::cout, DraftToJson(response.draft()));
  } else {
    std::cout << "created " << response.draft().name() << '\n';
  }
  return absl::OkStatus();
}

std::vector<std::string> DraftToRow(const v1::MapDraft& draft) {
  return {IdOf(draft.name()),
          draft.display_name(),
          draft.author(),
          StateText(draft),
          std::to_string(draft.active_edits()),
          FormatTime(draft.create_time())};
}

absl::Status ListDrafts(const Globals& globals, const DraftCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::ListMapDraftsRequest request;
  request.set_parent(map.name());
  if (!options.with_published) request.set_state(v1::MapDraft::STATE_OPEN);
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::MapDraft> drafts,
                            client::ListAll(connection, &v1::MapEditService::Stub::ListMapDrafts, request,
                                            &v1::ListMapDraftsResponse::drafts));
  PrintList<v1::MapDraft>(globals, drafts, {"DRAFT", "NAME", "AUTHOR", "STATE", "EDITS", "CREATED (UTC)"}, DraftToJson,
                          DraftToRow);
  return absl::OkStatus();
}

std::string ShapeText(const v1::MapEdit& edit) {
  if (edit.has_brush()) return fmt::format("brush of {} points", edit.brush().points_size());
  if (edit.has_line()) return fmt::format("line of {} points", edit.line().points_size());
  if (edit.has_polygon()) return fmt::format("polygon of {} rings", edit.polygon().rings_size());
  return fmt::format("patch of {} x {} cells", edit.patch().box().width(), edit.patch().box().height());
}

// As in the API.
nlohmann::json EditToJson(const v1::MapEdit& edit) {
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(edit, &text).ok()) return nullptr;
  return nlohmann::json::parse(text, nullptr, false);
}

absl::Status ShowDraft(const Globals& globals, const DraftCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::GetMapDraftRequest get;
  ENFILADE_ASSIGN_OR_RETURN(*get.mutable_name(), FindDraftName(connection, globals, options.map, options.draft));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, connection.Call(&v1::MapEditService::Stub::GetMapDraft, get));
  v1::ListMapEditsRequest list;
  list.set_parent(found.draft().name());
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<v1::MapEdit> edits,
      client::ListAll(connection, &v1::MapEditService::Stub::ListMapEdits, list, &v1::ListMapEditsResponse::edits));
  if (globals.json) {
    nlohmann::json document = DraftToJson(found.draft());
    document["edits"] = nlohmann::json::array();
    for (const v1::MapEdit& edit : edits) document["edits"].push_back(EditToJson(edit));
    PrintJson(std::cout, document);
    return absl::OkStatus();
  }
  std::cout << found.draft().name() << "  " << StateText(found.draft()) << ", cells of "
            << found.draft().lattice().resolution_m() << " m\n";
  if (!found.draft().message().empty()) std::cout << found.draft().message() << '\n';
  std::vector<std::vector<std::string>> rows;
  for (const v1::MapEdit& edit : edits) {
    rows.push_back({edit.edit_id(), ValueText(edit.value()) + (edit.invisible() ? ", invisible" : ""), ShapeText(edit),
                    edit.author(), edit.active() ? "" : "undone", FormatTime(edit.create_time())});
  }
  PrintTable(std::cout, {"EDIT", "CELLS ARE", "SHAPE", "AUTHOR", "STATE", "DRAWN (UTC)"}, rows);
  return absl::OkStatus();
}

absl::Status DeleteDraft(const Globals& globals, const DraftCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::DeleteMapDraftRequest request;
  ENFILADE_ASSIGN_OR_RETURN(*request.mutable_name(), FindDraftName(connection, globals, options.map, options.draft));
  ENFILADE_RETURN_IF_ERROR(connection.Call(&v1::MapEditService::Stub::DeleteMapDraft, request).status());
  if (globals.json) {
    PrintJson(std::cout, {{"deleted", request.name()}});
  } else {
    std::cout << "deleted " << request.name() << '\n';
  }
  return absl::OkStatus();
}

absl::Status SwitchEdits(const Globals& globals, const DraftCommandOptions& options, bool active) {
  const client::Connection connection = ConnectionOf(globals);
  v1::SetMapEditsActiveRequest request;
  ENFILADE_ASSIGN_OR_RETURN(*request.mutable_name(), FindDraftName(connection, globals, options.map, options.draft));
  request.mutable_edit_ids()->Assign(options.edits.begin(), options.edits.end());
  request.set_active(active);
  request.set_others(options.others);
  ENFILADE_ASSIGN_OR_RETURN(const auto response,
                            connection.Call(&v1::MapEditService::Stub::SetMapEditsActive, request));
  if (globals.json) {
    PrintJson(std::cout, {{"head", response.head()}, {"changed", response.edits_size()}});
  } else {
    std::cout << response.edits_size() << " edits " << (active ? "redone" : "undone") << '\n';
  }
  return absl::OkStatus();
}

void AddDraftArguments(CLI::App& command, const std::shared_ptr<DraftCommandOptions>& options) {
  command.add_option("MAP", options->map, "The map's name, id or resource name")->required();
  command.add_option("DRAFT", options->draft, "The draft's id or resource name")->required();
}

void AddSwitch(CLI::App& group, const Globals& globals, bool active) {
  const auto options = std::make_shared<DraftCommandOptions>();
  CLI::App* command = AddCommand(group, active ? "redo" : "undo",
                                 active ? "Switch edits of a draft on again" : "Switch edits of a draft off",
                                 [&globals, options, active] { return SwitchEdits(globals, *options, active); });
  AddDraftArguments(*command, options);
  command->add_option("EDIT", options->edits, "Ids of edits (enfilade map draft show)")->required();
  command->add_flag("--others", options->others, "Also edits of other people");
}

}  // namespace

void AddMapDraft(CLI::App& map, const Globals& globals) {
  CLI::App* group = map.add_subcommand("draft", "Edits of a map that are not published yet");
  group->require_subcommand(1);
  const auto options = std::make_shared<DraftCommandOptions>();
  CLI::App* create =
      AddCommand(*group, "create", "Begin a draft", [&globals, options] { return CreateDraft(globals, *options); });
  create->add_option("MAP", options->map, "The map's name, id or resource name")->required();
  create->add_option("NAME", options->name, "What it is about, at most 200 characters");
  create->add_option("--id", options->draft, "Its id: 1 to 63 of a-z, 0-9 and \"-\" (default: a new one)");
  create->footer("Example: enfilade map draft create \"Main hall\" \"Glass walls\" --id glass");

  CLI::App* list = AddCommand(*group, "list", "List a map's open drafts, the newest first",
                              [&globals, options] { return ListDrafts(globals, *options); });
  list->add_option("MAP", options->map, "The map's name, id or resource name")->required();
  list->add_flag("--published", options->with_published, "Also those that are published");

  CLI::App* show = AddCommand(*group, "show", "Show a draft and its edits",
                              [&globals, options] { return ShowDraft(globals, *options); });
  AddDraftArguments(*show, options);
  show->footer("Example: enfilade map draft show \"Main hall\" glass");

  CLI::App* remove = AddCommand(*group, "delete", "Delete an open draft with its edits",
                                [&globals, options] { return DeleteDraft(globals, *options); });
  AddDraftArguments(*remove, options);
  AddSwitch(*group, globals, false);
  AddSwitch(*group, globals, true);
}

}  // namespace enfilade::cli
