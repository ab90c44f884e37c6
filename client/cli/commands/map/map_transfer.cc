// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/map/map_transfer.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "client/cli/map_file_reader.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/files/map_files.h"
#include "enfilade/v1/map_service.grpc.pb.h"

namespace enfilade::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunkBytes = 1U << 20;

struct MapExportCommandOptions {
  std::string map;
  std::string directory = ".";
  std::string format = "pgm";
};

absl::StatusOr<v1::MapFormat> MapFormatOf(const std::string& format) {
  if (format == "pgm") return v1::MAP_FORMAT_PGM;
  if (format == "png") return v1::MAP_FORMAT_PNG;
  if (format == "json") return v1::MAP_FORMAT_JSON;
  return InvalidArgument("format \"{}\": expected pgm, png or json", format);
}

// Files being received: each is written under a temporary name, checked, and gets its own name at the end.
class ReceivedFiles {
 public:
  ReceivedFiles(fs::path directory, v1::ExportMapManifest manifest)
      : directory_(std::move(directory)), manifest_(std::move(manifest)), hashes_(manifest_.files().size()) {}
  ~ReceivedFiles() {
    std::error_code ignored;
    for (int i = 0; i < manifest_.files_size(); ++i) fs::remove(PartOf(i), ignored);
  }

  absl::Status Add(const v1::FileChunk& chunk) {
    if (chunk.file() < 0 || chunk.file() >= manifest_.files_size()) return DataLoss("the server sent an unknown file");
    if (chunk.offset() == 0) {
      out_ = std::ofstream(PartOf(chunk.file()), std::ios::binary | std::ios::trunc);
      if (!out_) return InvalidArgument("cannot write to {}", PartOf(chunk.file()).string());
    }
    out_.write(chunk.data().data(), static_cast<std::streamsize>(chunk.data().size()));
    hashes_[static_cast<std::size_t>(chunk.file())].Add(chunk.data());
    if (!out_.flush()) return ResourceExhausted("{}: cannot be written: is the disk full?", directory_.string());
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<fs::path>> Finish() {
    std::vector<fs::path> paths;
    for (int i = 0; i < manifest_.files_size(); ++i) {
      const v1::FileEntry& file = manifest_.files(i);
      if (hashes_[static_cast<std::size_t>(i)].Finish() != file.sha256()) {
        return DataLoss("{} was damaged on its way: try again", file.name());
      }
    }
    for (int i = 0; i < manifest_.files_size(); ++i) {
      paths.push_back(directory_ / fs::path(manifest_.files(i).name()).filename());
      fs::rename(PartOf(i), paths.back());
    }
    return paths;
  }

 private:
  fs::path PartOf(int file) const {
    return directory_ / (fs::path(manifest_.files(file).name()).filename().string() + ".part");
  }

  const fs::path directory_;
  const v1::ExportMapManifest manifest_;
  std::vector<Sha256Stream> hashes_;
  std::ofstream out_;
};

absl::Status ExportMap(const Globals& globals, const MapExportCommandOptions& options) {
  const client::Connection connection = ConnectionOf(globals);
  v1::ExportMapRequest request;
  ENFILADE_ASSIGN_OR_RETURN(const v1::MapFormat format, MapFormatOf(options.format));
  request.set_format(format);
  if (options.map.find("/revisions/") != std::string::npos && options.map.rfind("sites/", 0) == 0) {
    request.set_name(options.map);
  } else {
    ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
    request.set_name(map.name());
  }
  std::error_code error;
  fs::create_directories(options.directory, error);
  if (error) return InvalidArgument("cannot make the folder {}: {}", options.directory, error.message());

  v1::MapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  const auto reader = stub.ExportMap(&context, request);
  v1::ExportMapResponse part;
  if (!reader->Read(&part)) return client::FromGrpcStatus(reader->Finish(), connection.address());
  if (!part.has_manifest()) return DataLoss("the server's first message is no manifest");
  const v1::MapRevision revision = part.manifest().revision();
  std::int64_t total = 0;
  for (const v1::FileEntry& file : part.manifest().files()) total += file.size_bytes();
  ProgressBar progress(globals, "downloading", total, "B");
  ReceivedFiles files(options.directory, part.manifest());
  std::int64_t received = 0;
  while (reader->Read(&part)) {
    ENFILADE_RETURN_IF_ERROR(files.Add(part.chunk()));
    progress.Update(received += static_cast<std::int64_t>(part.chunk().data().size()));
  }
  ENFILADE_RETURN_IF_ERROR(client::FromGrpcStatus(reader->Finish(), connection.address()));
  progress.Finish();
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<fs::path> paths, files.Finish());
  if (globals.json) {
    nlohmann::json document{{"revision", revision.name()},
                            {"width", revision.width()},
                            {"height", revision.height()},
                            {"resolution_m", revision.resolution_m()},
                            {"bytes", total}};
    for (const fs::path& path : paths) document["files"].push_back(path.string());
    PrintJson(std::cout, document);
  } else {
    std::cout << revision.name() << ": " << revision.width() << " x " << revision.height() << " cells of "
              << revision.resolution_m() << " m\n";
    for (const fs::path& path : paths) std::cout << path.string() << '\n';
  }
  return absl::OkStatus();
}

struct MapImportCommandOptions {
  std::string file;
  std::string map;
  std::string dialect = "nav2";
  int level = 0;
};

absl::StatusOr<v1::Map> FindOrCreateMap(const client::Connection& connection, const Globals& globals,
                                        const MapImportCommandOptions& options) {
  auto found = FindMap(connection, globals, options.map);
  if (found.ok() || !absl::IsNotFound(found.status())) return found;
  v1::CreateMapRequest request;
  request.set_parent(SiteNameOf(globals));
  request.mutable_map()->set_display_name(options.map);
  request.mutable_map()->set_level(options.level);
  ENFILADE_ASSIGN_OR_RETURN(const v1::CreateMapResponse created,
                            connection.Call(&v1::MapService::Stub::CreateMap, request));
  return created.map();
}

void SendMap(grpc::ClientWriter<v1::ImportMapRequest>& writer, const v1::Map& map,
             const MapImportCommandOptions& options, const std::vector<grid::MapFile>& files, ProgressBar& progress) {
  v1::ImportMapRequest message;
  message.mutable_manifest()->set_parent(map.name());
  message.mutable_manifest()->set_dialect(options.dialect == "ros1" ? v1::MAP_DIALECT_ROS1 : v1::MAP_DIALECT_NAV2);
  for (const grid::MapFile& file : files) {
    v1::FileEntry& entry = *message.mutable_manifest()->add_files();
    entry.set_name(file.name);
    entry.set_size_bytes(static_cast<std::int64_t>(file.bytes.size()));
    entry.set_sha256(Sha256(file.bytes));
  }
  bool open = writer.Write(message);
  std::int64_t sent = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (std::size_t offset = 0; open && offset < files[i].bytes.size(); offset += kChunkBytes) {
      v1::FileChunk& chunk = *message.mutable_chunk();
      chunk.set_file(static_cast<std::int32_t>(i));
      chunk.set_offset(static_cast<std::int64_t>(offset));
      chunk.set_data(files[i].bytes.substr(offset, kChunkBytes));
      open = writer.Write(message);
      progress.Update(sent += static_cast<std::int64_t>(chunk.data().size()));
    }
  }
  writer.WritesDone();  // where the server hung up, Finish tells why
}

absl::Status ImportMap(const Globals& globals, const MapImportCommandOptions& options) {
  if (options.dialect != "nav2" && options.dialect != "ros1") {
    return InvalidArgument("dialect \"{}\": expected nav2 or ros1", options.dialect);
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<grid::MapFile> files, ReadMapFiles(options.file));
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindOrCreateMap(connection, globals, options));
  std::int64_t total = 0;
  for (const grid::MapFile& file : files) total += static_cast<std::int64_t>(file.bytes.size());
  ProgressBar progress(globals, "uploading", total, "B");
  v1::MapService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  v1::ImportMapResponse response;
  const auto writer = stub.ImportMap(&context, &response);
  SendMap(*writer, map, options, files, progress);
  ENFILADE_RETURN_IF_ERROR(client::FromGrpcStatus(writer->Finish(), connection.address()));
  progress.Finish();
  const v1::MapRevision& revision = response.revision();
  for (const std::string& warning : response.warnings()) std::cerr << "warning: " << warning << '\n';
  if (globals.json) {
    PrintJson(std::cout, {{"revision", revision.name()},
                          {"width", revision.width()},
                          {"height", revision.height()},
                          {"resolution_m", revision.resolution_m()}});
  } else {
    std::cout << revision.name() << ": " << revision.width() << " x " << revision.height() << " cells of "
              << revision.resolution_m() << " m\n";
  }
  return absl::OkStatus();
}

}  // namespace

void AddMapExport(CLI::App& map, const Globals& globals) {
  auto options = std::make_shared<MapExportCommandOptions>();
  CLI::App* command = AddCommand(map, "export", "Write a map's newest (or the named) revision as files",
                                 [&globals, options] { return ExportMap(globals, *options); });
  command->add_option("MAP", options->map, "The map's name, id or resource name, or a revision's resource name")
      ->required();
  command->add_option("-o,--output", options->directory, "The folder to write to")->capture_default_str();
  command->add_option("--format", options->format, "pgm or png (each with a YAML for Nav2), or json")
      ->capture_default_str();
  command->footer("Example: enfilade map export \"Main hall\" -o maps --format png");
}

void AddMapImport(CLI::App& map, const Globals& globals) {
  auto options = std::make_shared<MapImportCommandOptions>();
  CLI::App* command = AddCommand(map, "import", "Make files a map's newest revision",
                                 [&globals, options] { return ImportMap(globals, *options); });
  command->add_option("FILE", options->file, "A .yaml beside the PGM or PNG that it names, or a .json")->required();
  command->add_option("--map", options->map, "The map's name, id or resource name; made where there is none")
      ->required();
  command->add_option("--dialect", options->dialect, "nav2 or ros1: whose rules the thresholds follow")
      ->capture_default_str();
  command->add_option("--level", options->level, "The floor of a map that is made")->capture_default_str();
  command->footer("Example: enfilade map import hall.yaml --map \"Main hall\"");
}

}  // namespace enfilade::cli
