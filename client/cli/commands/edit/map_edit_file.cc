// SPDX-License-Identifier: Apache-2.0
// `enfilade map edit`.
#include <iostream>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/edit/draft_output.h"
#include "client/cli/commands/edit/edit_file.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

constexpr int kMaxEditsOfCall = 100;
constexpr std::size_t kMaxBytesOfCall = 1 << 20;

struct EditFileCommandOptions {
  std::string map;
  std::string file;
  std::string draft;
};

struct DraftToDrawIn {
  v1::MapDraft draft;
  bool is_new = false;
};

// The one that is named, created if it is missing, or a new one.
absl::StatusOr<DraftToDrawIn> FindOrCreateDraft(const client::Connection& connection, const Globals& globals,
                                                const EditFileCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  if (!options.draft.empty()) {
    v1::GetMapDraftRequest get;
    get.set_name(options.draft.starts_with("sites/") ? options.draft : map.name() + "/drafts/" + options.draft);
    const auto found = connection.Call(&v1::MapEditService::Stub::GetMapDraft, get);
    if (found.ok()) return DraftToDrawIn{found->draft(), false};
    if (!absl::IsNotFound(found.status()) || options.draft.starts_with("sites/")) return found.status();
  }
  v1::CreateMapDraftRequest create;
  create.set_parent(map.name());
  create.set_draft_id(options.draft);
  create.set_request_id(NewUuid());
  ENFILADE_ASSIGN_OR_RETURN(const auto created, connection.Call(&v1::MapEditService::Stub::CreateMapDraft, create));
  return DraftToDrawIn{created.draft(), true};
}

struct AppendedEdits {
  int sent = 0;
  int added = 0;
};

// In calls of no more than the server takes. An error names what is in the draft already.
absl::Status AppendEdits(const client::Connection& connection, const Globals& globals, const std::string& draft,
                         std::vector<v1::MapEdit> edits, AppendedEdits& done) {
  ProgressBar bar(globals, "drawing", static_cast<std::int64_t>(edits.size()), "");
  for (std::size_t next = 0; next < edits.size();) {
    v1::AppendMapEditsRequest request;
    request.set_name(draft);
    for (std::size_t bytes = 0; next < edits.size() && request.edits_size() < kMaxEditsOfCall; ++next) {
      bytes += edits[next].ByteSizeLong();
      if (request.edits_size() > 0 && bytes > kMaxBytesOfCall) break;
      *request.add_edits() = std::move(edits[next]);
    }
    const auto response = connection.Call(&v1::MapEditService::Stub::AppendMapEdits, request);
    if (!response.ok()) {
      if (done.sent == 0) return response.status();
      return WithContext(response.status(),
                         fmt::format("{} edits are drawn; in those from edits[{}] on", done.sent, done.sent));
    }
    done.sent += request.edits_size();
    done.added += response->edits_size();
    bar.Update(done.sent);
  }
  bar.Finish();
  return absl::OkStatus();
}

absl::Status DrawFile(const client::Connection& connection, const Globals& globals, const v1::MapDraft& draft,
                      const std::string& yaml, AppendedEdits& done) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<v1::MapEdit> edits, ReadEdits(yaml, LatticeOf(draft.lattice())));
  GiveIds(draft.name(), edits);
  return AppendEdits(connection, globals, draft.name(), std::move(edits), done);
}

absl::Status DrawEdits(const Globals& globals, const EditFileCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const std::string yaml, io::ReadFile(options.file));
  ENFILADE_ASSIGN_OR_RETURN(const DraftToDrawIn target, FindOrCreateDraft(connection, globals, options));
  const v1::MapDraft& draft = target.draft;
  AppendedEdits done;
  if (const absl::Status drawn = DrawFile(connection, globals, draft, yaml, done); !drawn.ok()) {
    v1::DeleteMapDraftRequest remove;  // nothing is in it
    remove.set_name(draft.name());
    if (target.is_new && done.sent == 0)
      ENFILADE_RETURN_IF_ERROR(connection.Call(&v1::MapEditService::Stub::DeleteMapDraft, remove).status());
    return WithContext(drawn, options.file);
  }
  if (globals.json) {
    PrintJson(std::cout, {{"draft", draft.name()}, {"added", done.added}, {"already_there", done.sent - done.added}});
    return absl::OkStatus();
  }
  std::cout << done.added << " edits drawn in " << draft.name();
  if (done.sent > done.added) std::cout << ", which has the other " << done.sent - done.added << " already";
  std::cout << '\n';
  return absl::OkStatus();
}

}  // namespace

void AddMapEditFile(CLI::App& map, const Globals& globals) {
  const auto options = std::make_shared<EditFileCommandOptions>();
  CLI::App* command = AddCommand(map, "edit", "Draw the edits of a YAML file into a draft",
                                 [&globals, options] { return DrawEdits(globals, *options); });
  command->add_option("MAP", options->map, "The map's name, id or resource name")->required();
  command->add_option("FILE", options->file, "The YAML file")->required();
  command->add_option("--draft", options->draft, "The draft's id; created if missing (default: a new draft)");
  command->footer(
      "The file has a list of edits, in the order in which they are drawn:\n"
      "  unit: m            # or cells: (3, 5) is the centre of column 3, row 5 (default: m, in the map's frame)\n"
      "  author: Ann        # (default: --actor)\n"
      "  edits:\n"
      "  - {brush: [[1, 2], [3, 2.5]], radius: 0.15, value: free}\n"
      "  - {line: [[0, 0], [4, 0]], value: occupied, invisible: true}\n"
      "  - {polygon: [[0, 0], [4, 0], [4, 3]], holes: [[[2, 0.5], [3, 0.5], [3, 1]]], value: unknown}\n"
      "  - {rectangle: [[0, 0], [4, 3]], value: free, only_where: [unknown]}\n"
      "  - {fill: [2, 2], bounds: [[0, 0], [9, 9]], value: free}\n"
      "  - {patch: [\"##.\", \"#..\"], at: [1, 1], value: clear}   # rows of cells; at: the lowest left one\n"
      "value: unknown, free, occupied, or clear, which takes edits away. only_where: only cells that show these.\n"
      "invisible: scanners cannot see it. Sending a file again changes nothing.\n"
      "Example: enfilade map edit \"Main hall\" glass.yaml --draft glass");
}

}  // namespace enfilade::cli
