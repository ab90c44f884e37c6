// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/paging.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

constexpr int kShownRevisions = 10;

std::string EnvironmentName(v1::Map::Environment environment) {
  return environment == v1::Map::ENVIRONMENT_OUTDOOR ? "outdoor" : "indoor";
}

nlohmann::json ToJson(const v1::Map& map) {
  return {{"name", map.name()},
          {"display_name", map.display_name()},
          {"level", map.level()},
          {"environment", EnvironmentName(map.environment())},
          {"slam_profile", map.slam_profile()},
          {"pinned", map.pinned()},
          {"latest_revision", map.latest_revision()},
          {"etag", map.etag()},
          {"create_time", FormatTime(map.create_time())}};
}

std::string SourceName(const v1::MapRevision& revision) {
  return EnumText(v1::MapRevision::Source_Name(revision.source()), "SOURCE_");
}

std::string AliasesOf(const v1::MapRevision& revision) {
  std::string aliases;
  for (const std::string& alias : revision.aliases()) aliases += (aliases.empty() ? "" : ", ") + alias;
  return aliases;
}

nlohmann::json ToJson(const v1::MapRevision& revision) {
  return {{"name", revision.name()},
          {"tag", revision.tag()},
          {"aliases", std::vector<std::string>(revision.aliases().begin(), revision.aliases().end())},
          {"source", SourceName(revision)},
          {"session", revision.session()},
          {"resolution_m", revision.resolution_m()},
          {"origin", {revision.pose_map_grid().x(), revision.pose_map_grid().y(), revision.pose_map_grid().yaw()}},
          {"width", revision.width()},
          {"height", revision.height()},
          {"content_sha256", ToHex(revision.content_sha256())},
          {"create_time", FormatTime(revision.create_time())}};
}

std::vector<std::string> ToRow(const v1::Map& map) {
  return {IdOf(map.name()),
          map.display_name(),
          std::to_string(map.level()),
          EnvironmentName(map.environment()),
          IdOf(map.latest_revision()),
          FormatTime(map.create_time())};
}

absl::Status ListMaps(const Globals& globals) {
  v1::ListMapsRequest request;
  request.set_parent(SiteNameOf(globals));
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<v1::Map> maps,
      client::ListAll(ConnectionOf(globals), &v1::MapService::Stub::ListMaps, request, &v1::ListMapsResponse::maps));
  PrintList<v1::Map>(globals, maps, {"MAP", "NAME", "LEVEL", "ENVIRONMENT", "REVISION", "CREATED (UTC)"}, ToJson,
                     ToRow);
  return absl::OkStatus();
}

absl::Status ShowMap(const Globals& globals, const std::string& name) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, name));
  v1::ListMapRevisionsRequest request;
  request.set_parent(map.name());
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<v1::MapRevision> revisions,
                            client::ListAll(connection, &v1::MapService::Stub::ListMapRevisions, request,
                                            &v1::ListMapRevisionsResponse::revisions, kShownRevisions));
  if (globals.json) {
    nlohmann::json document = ToJson(map);
    for (const v1::MapRevision& revision : revisions) document["revisions"].push_back(ToJson(revision));
    PrintJson(std::cout, document);
    return absl::OkStatus();
  }
  std::cout << map.display_name() << "\n"
            << map.name() << "  level " << map.level() << ", " << EnvironmentName(map.environment())
            << (map.pinned() ? ", pinned\n" : "\n");
  std::vector<std::vector<std::string>> rows;
  for (const v1::MapRevision& revision : revisions) {
    rows.push_back({IdOf(revision.name()),
                    revision.session().empty() ? SourceName(revision) : "session " + IdOf(revision.session()),
                    fmt::format("{} x {} cells of {} m", revision.width(), revision.height(), revision.resolution_m()),
                    FormatTime(revision.create_time()), revision.tag(), AliasesOf(revision)});
  }
  PrintTable(std::cout, {"REVISION", "FROM", "SIZE", "CREATED (UTC)", "TAG", "ALIASES"}, rows);
  return absl::OkStatus();
}

struct TagMapCommandOptions {
  std::string map;
  std::int64_t revision = 0;
  std::string tag;
};

absl::Status TagMap(const Globals& globals, const TagMapCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::TagMapRevisionRequest request;
  request.set_name(options.revision == 0 ? map.latest_revision()
                                         : fmt::format("{}/revisions/{}", map.name(), options.revision));
  request.set_tag(options.tag);
  if (request.name().empty()) return FailedPrecondition("\"{}\" has no revision yet", map.display_name());
  ENFILADE_ASSIGN_OR_RETURN(const v1::TagMapRevisionResponse response,
                            connection.Call(&v1::MapService::Stub::TagMapRevision, request));
  if (globals.json) {
    PrintJson(std::cout, ToJson(response.revision()));
  } else if (options.tag.empty()) {
    std::cout << response.revision().name() << " has no tag\n";
  } else {
    std::cout << response.revision().name() << " is \"" << response.revision().tag() << "\"\n";
  }
  return absl::OkStatus();
}

struct DeleteMapCommandOptions {
  std::string map;
  bool force = false;
};

absl::Status DeleteMap(const Globals& globals, const DeleteMapCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
  v1::DeleteMapRequest request;
  request.set_name(map.name());
  request.set_etag(map.etag());
  request.set_force(options.force);
  ENFILADE_RETURN_IF_ERROR(connection.Call(&v1::MapService::Stub::DeleteMap, request).status());
  if (globals.json) {
    PrintJson(std::cout, {{"deleted", map.name()}});
  } else {
    std::cout << "deleted \"" << map.display_name() << "\" (" << map.name() << ")\n";
  }
  return absl::OkStatus();
}

}  // namespace

void AddMap(CLI::App& app, const Globals& globals) {
  CLI::App* map = app.add_subcommand("map", "Maps and their files");
  map->require_subcommand(1);
  AddCommand(*map, "list", "List the site's maps", [&globals] { return ListMaps(globals); });

  auto name = std::make_shared<std::string>();
  CLI::App* show = AddCommand(*map, "show", "Show a map and its newest revisions",
                              [&globals, name] { return ShowMap(globals, *name); });
  show->add_option("MAP", *name, "Its name, id or resource name")->required();
  show->footer("Example: enfilade map show \"Main hall\"");

  AddMapAlias(*map, globals);
  AddMapDiff(*map, globals);
  AddMapAlign(*map, globals);
  AddMapEdit(*map, globals);
  AddMapDraft(*map, globals);
  AddMapEditFile(*map, globals);
  AddMapPublish(*map, globals);
  AddMapContested(*map, globals);
  AddMapExport(*map, globals);
  AddMapImport(*map, globals);
  AddMapRearrange(*map, globals);
  AddMapPins(*map, globals);

  auto tag_options = std::make_shared<TagMapCommandOptions>();
  CLI::App* tag = AddCommand(*map, "tag", "Give a revision a name; it is then kept however old it is",
                             [&globals, tag_options] { return TagMap(globals, *tag_options); });
  tag->add_option("MAP", tag_options->map, "Its name, id or resource name")->required();
  tag->add_option("TAG", tag_options->tag, "At most 64 characters; none: the tag is removed");
  tag->add_option("--revision", tag_options->revision, "Of this revision (default: the newest)")
      ->check(CLI::PositiveNumber);
  tag->footer("Example: enfilade map tag \"Main hall\" \"before the move\"");

  auto options = std::make_shared<DeleteMapCommandOptions>();
  CLI::App* remove = AddCommand(*map, "delete", "Delete a map with its revisions",
                                [&globals, options] { return DeleteMap(globals, *options); });
  remove->add_option("MAP", options->map, "Its name, id or resource name")->required();
  remove->add_flag("--force", options->force, "Also delete the sessions that were recorded into it");
  remove->footer("Example: enfilade map delete \"Main hall\" --force");
}

}  // namespace enfilade::cli
