// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/sdk/api/map_export.h"
#include "client/sdk/api/map_import.h"
#include "client/simulator/simulation.h"
#include "core/edit/apply.h"
#include "core/grid/raster_header.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "server/app/mapping/raster_revision.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {

// Map "m", imported as a room with walls of one cell, or mapped by robots, and its drafts.
class MapEditFixture : public ServerTest {
 protected:
  static constexpr int kWidth = 50;  // cells
  static constexpr int kHeight = 40;

  // 254 free, 0 occupied; the highest row first.
  static std::string RoomPixels() {
    std::string pixels;
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        const bool wall = row == 0 || column == 0 || row == kHeight - 1 || column == kWidth - 1;
        pixels += wall ? '\0' : '\xFE';
      }
    }
    return pixels;
  }
  // `origin`: of its lower-left corner, m.
  void ImportRoom(bool keep_edits = false, const std::string& origin = "0, 0") {
    const std::string pgm = "P5\n" + std::to_string(kWidth) + " " + std::to_string(kHeight) + "\n255\n" + RoomPixels();
    const std::string yaml = "image: room.pgm\nresolution: 0.1\norigin: [" + origin +
                             ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
    Import({{"room.pgm", pgm}, {"room.yaml", yaml}}, keep_edits);
  }
  void ImportJson() {
    Import({{"room.json",
             R"({"xmin": 0, "xmax": 0.2, "ymin": 0, "ymax": 0.2, "stepx": 0.1, "stepy": 0.1, "level": 10,
                 "data": [0, 0, 0, 0, 0, 0, 0, 0, 1]})"}},
           false);
  }

  // The pixels of the exported PGM.
  std::string ExportedPixels(bool without_edits = false) {
    v1::ExportMapRequest request;
    request.set_name("sites/s/maps/m");
    request.set_format(v1::MAP_FORMAT_PGM);
    request.set_without_edits(without_edits);
    const auto map = client::DownloadMap(*connection_, request);
    EXPECT_OK(map);
    if (!map.ok()) return "";
    for (const auto& file : map->files) {
      if (file.name.ends_with(".pgm")) return file.bytes.substr(file.bytes.size() - std::size_t{kWidth} * kHeight);
    }
    return "";
  }
  bool IsOccupied(int column, int row) {
    const std::string pixels = ExportedPixels();
    return pixels[static_cast<std::size_t>((kHeight - 1 - row) * kWidth + column)] == '\0';
  }

  // The middle of a cell.
  static v1::LatticePoint At(int column, int row) {
    v1::LatticePoint point;
    point.set_x(column * 256 + 128);
    point.set_y(row * 256 + 128);
    return point;
  }
  static v1::CellBox Box(int column, int row, int width, int height) {
    v1::CellBox box;
    box.set_first_column(column);
    box.set_first_row(row);
    box.set_width(width);
    box.set_height(height);
    return box;
  }
  // `radius` in cells.
  static v1::MapEdit Brush(const std::string& id, v1::MapEdit::Value value,
                           const std::vector<std::pair<int, int>>& cells, double radius) {
    v1::MapEdit edit;
    edit.set_edit_id(id);
    edit.set_value(value);
    edit.mutable_brush()->set_radius(static_cast<int>(radius * 256));
    for (const auto& [column, row] : cells) *edit.mutable_brush()->add_points() = At(column, row);
    return edit;
  }
  static v1::MapEdit Patch(const std::string& id, v1::MapEdit::Value value, const v1::CellBox& box) {
    v1::MapEdit edit;
    edit.set_edit_id(id);
    edit.set_value(value);
    *edit.mutable_patch()->mutable_box() = box;
    edit.mutable_patch()->add_runs(0);
    edit.mutable_patch()->add_runs(static_cast<std::uint32_t>(box.width() * box.height()));
    return edit;
  }

  std::string CreateDraft(const std::string& id) {
    v1::CreateMapDraftRequest request;
    request.set_parent("sites/s/maps/m");
    request.set_draft_id(id);
    const auto response = Call(&v1::MapEditService::Stub::CreateMapDraft, request);
    EXPECT_OK(response);
    return response.ok() ? response->draft().name() : "";
  }
  absl::StatusOr<v1::AppendMapEditsResponse> Append(const std::string& draft, const std::vector<v1::MapEdit>& edits) {
    v1::AppendMapEditsRequest request;
    request.set_name(draft);
    for (const v1::MapEdit& edit : edits) *request.add_edits() = edit;
    return Call(&v1::MapEditService::Stub::AppendMapEdits, request);
  }
  absl::StatusOr<v1::SetMapEditsActiveResponse> SetActive(const std::string& draft, const std::vector<std::string>& ids,
                                                          bool active, const std::string& author = "") {
    v1::SetMapEditsActiveRequest request;
    request.set_name(draft);
    request.mutable_edit_ids()->Assign(ids.begin(), ids.end());
    request.set_active(active);
    request.set_author(author);
    return Call(&v1::MapEditService::Stub::SetMapEditsActive, request);
  }
  absl::StatusOr<std::vector<v1::MapEdit>> Edits(const std::string& draft) {
    v1::ListMapEditsRequest request;
    request.set_parent(draft);
    const auto response = Call(&v1::MapEditService::Stub::ListMapEdits, request);
    if (!response.ok()) return response.status();
    return std::vector<v1::MapEdit>(response->edits().begin(), response->edits().end());
  }
  absl::StatusOr<v1::CheckMapDraftResponse> Check(const std::string& draft) {
    v1::CheckMapDraftRequest request;
    request.set_name(draft);
    return Call(&v1::MapEditService::Stub::CheckMapDraft, request);
  }
  absl::StatusOr<v1::RebaseMapDraftResponse> Rebase(const std::string& draft, std::int64_t edit_version,
                                                    const v1::CellBox& box, bool mine) {
    return Rebase(draft, edit_version, {{box, mine}});
  }
  absl::StatusOr<v1::RebaseMapDraftResponse> Rebase(const std::string& draft, std::int64_t edit_version,
                                                    const std::vector<std::pair<v1::CellBox, bool>>& is_mine) {
    v1::RebaseMapDraftRequest request;
    request.set_name(draft);
    request.set_edit_version(edit_version);
    for (const auto& [box, mine] : is_mine) {
      v1::MapEditResolution& resolution = *request.add_resolutions();
      *resolution.mutable_box() = box;
      resolution.set_choice(mine ? v1::MapEditResolution::CHOICE_MINE : v1::MapEditResolution::CHOICE_THEIRS);
    }
    return Call(&v1::MapEditService::Stub::RebaseMapDraft, request);
  }
  absl::StatusOr<v1::PublishMapDraftResponse> Publish(const std::string& draft, const std::string& message,
                                                      bool confirm = false) {
    v1::PublishMapDraftRequest request;
    request.set_name(draft);
    request.set_message(message);
    request.set_confirm_warnings(confirm);
    return Call(&v1::MapEditService::Stub::PublishMapDraft, request);
  }
  absl::StatusOr<std::vector<v1::ContestedEdit>> Contested() {
    v1::ListContestedEditsRequest request;
    request.set_parent("sites/s/maps/m");
    const auto response = Call(&v1::MapEditService::Stub::ListContestedEdits, request);
    if (!response.ok()) return response.status();
    return std::vector<v1::ContestedEdit>(response->contested().begin(), response->contested().end());
  }
  absl::Status Settle(const v1::ContestedEdit& place, v1::ContestSettlement::Choice choice) {
    v1::SettleContestedEditsRequest request;
    request.set_parent("sites/s/maps/m");
    request.set_message("settled");
    v1::ContestSettlement& settlement = *request.add_settlements();
    *settlement.mutable_box() = place.box();
    settlement.set_session(place.session());
    settlement.set_choice(choice);
    return Call(&v1::MapEditService::Stub::SettleContestedEdits, request).status();
  }

  // A candidate at a cell, whose coordinates may have fractions.
  void AddCandidate(const std::string& id, double column, double row) {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/s");
    request.set_link_point_id(id);
    v1::Anchor& anchor = *request.mutable_link_point()->add_anchors();
    anchor.set_map("sites/s/maps/m");
    anchor.mutable_pose_map_place()->mutable_pose()->set_x(0.1 * column);
    anchor.mutable_pose_map_place()->mutable_pose()->set_y(0.1 * row);
    EXPECT_OK(Call(&v1::LinkPointService::Stub::CreateLinkPoint, request));
  }

  // A robot drives through simulated rooms, from the same place each time. Gives its session.
  std::string MapLap() {
    simulator::SimulationOptions options = simulator::RoomsOptions();
    const auto drive = simulator::SimulateRooms(options);
    EXPECT_OK(drive);
    v1::CreateSessionRequest request;
    request.set_parent("sites/s");
    request.mutable_session()->set_robot("sites/s/robots/r");
    request.mutable_session()->set_map("sites/s/maps/m");
    if (start_) {
      const Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal();
      *request.mutable_session()->mutable_entry()->mutable_pose_map_robot() =
          convert::ToProto(PoseWithCovariance{*start_, covariance});
    }
    const auto created = Call(&v1::SessionService::Stub::CreateSession, request);
    EXPECT_OK(created);
    const std::string session = created->session().name();
    TestStream stream(*connection_, session);
    std::vector<v1::Record> batch;
    const std::size_t count = drive->records.size() * 3 / 10;
    for (std::size_t i = 0; i < count; ++i) {
      sensor::Record record{static_cast<std::int64_t>(i) + 1, {}};
      std::visit([&](const auto& payload) { record.payload = payload; }, drive->records[i].payload);
      batch.push_back(convert::ToProto(record));
      if (batch.size() < 200 && i + 1 < count) continue;
      EXPECT_TRUE(stream.SendBatch(batch));
      batch.clear();
    }
    EXPECT_TRUE(stream.AwaitAcknowledged(static_cast<std::int64_t>(count)));
    EXPECT_OK(FinishSession(session, static_cast<std::int64_t>(count)));
    AwaitState(session, v1::Session::STATE_MAPPED);
    if (!start_) {
      const SessionId id(session.substr(session.rfind('/') + 1));
      const auto mapped = storage::postgres::MappingStore(*pool_).ReadTrajectory(Soon(), SiteId("s"), id);
      EXPECT_OK(mapped);
      start_ = mapped->poses.front().T_map_robot;
    }
    return session;
  }

  // What the newest revision shows.
  struct Picture {
    edit::CellBox box;
    std::vector<grid::CellClass> classes;

    grid::CellClass At(int column, int row) const {
      if (!box.contains(column, row)) return grid::CellClass::kUnknown;
      return classes[static_cast<std::size_t>((row - box.first_row) * box.width + column - box.first_column)];
    }
    int Count(const v1::CellBox& cells, grid::CellClass wanted) const {
      int count = 0;
      for (int row = cells.first_row(); row < cells.first_row() + cells.height(); ++row) {
        for (int column = cells.first_column(); column < cells.first_column() + cells.width(); ++column) {
          count += At(column, row) == wanted;
        }
      }
      return count;
    }
  };
  Picture Look() {
    const auto revision = revisions_.Get(Soon(), SiteId("s"), MapId("m"), 0);
    EXPECT_OK(revision);
    const auto raster = server::ReadRaster(Soon(), revisions_, *revision);
    EXPECT_OK(raster);
    const auto header = grid::DecodeRasterHeader(revision->raster_header);
    EXPECT_OK(header);
    return {edit::BoxOf(*header), edit::ClassesOf(*raster)};
  }
  bool Shows(const v1::CellBox& cells, v1::MapEdit::Value value) {
    const auto wanted = value == v1::MapEdit::VALUE_FREE ? grid::CellClass::kFree : grid::CellClass::kOccupied;
    return Look().Count(cells, wanted) == cells.width() * cells.height();
  }
  // Of 5 x 5 cells: that with the most occupied ones, and one that is free, far from the walls.
  v1::CellBox OccupiedBlock() { return Best(grid::CellClass::kOccupied, 0); }
  v1::CellBox FreeBlock() { return Best(grid::CellClass::kFree, 10); }

  // All of the cells. Gives its name.
  std::string IgnoreHitsIn(const v1::CellBox& cells) {
    v1::CreateMapAreaRequest request;
    request.set_parent("sites/s/maps/m");
    v1::MapArea& area = *request.mutable_area();
    area.set_display_name("Mirror");
    area.set_kind(v1::MapArea::KIND_IGNORE_HITS);
    const double left = 0.05 * cells.first_column(), right = left + 0.05 * cells.width();
    const double bottom = 0.05 * cells.first_row(), top = bottom + 0.05 * cells.height();
    for (const auto& [x, y] : {std::pair{left, bottom}, {right, bottom}, {right, top}, {left, top}}) {
      v1::Point& corner = *area.mutable_outline()->add_corners();
      corner.set_x(x);
      corner.set_y(y);
    }
    const auto created = Call(&v1::MapAreaService::Stub::CreateMapArea, request);
    EXPECT_OK(created);
    return created.ok() ? created->area().name() : "";
  }

 private:
  using Files = std::vector<std::pair<std::string, std::string>>;

  void Import(const Files& files, bool keep_edits) {
    std::vector<client::NamedFile> named;
    for (const auto& [name, bytes] : files) named.push_back({name, bytes});
    EXPECT_OK(client::ImportMap(*connection_, "sites/s/maps/m", v1::MAP_DIALECT_NAV2, named, {}, keep_edits));
  }
  v1::CellBox Best(grid::CellClass wanted, int margin) {
    const Picture picture = Look();
    v1::CellBox best;
    int most = -1;
    for (int row = picture.box.first_row + margin; row + 5 + margin < picture.box.end_row(); ++row) {
      for (int column = picture.box.first_column + margin; column + 5 + margin < picture.box.end_column(); ++column) {
        const v1::CellBox around = Box(column - margin, row - margin, 5 + 2 * margin, 5 + 2 * margin);
        const int count = picture.Count(around, wanted);
        if (count <= most) continue;
        most = count;
        best = Box(column, row, 5, 5);
      }
    }
    return best;
  }

  storage::postgres::RevisionStore revisions_{*pool_};
  std::optional<Pose2> start_;  // of the first lap, in the map
};

// A stream of WatchMapDraft.
class DraftStream {
 public:
  DraftStream(const client::Connection& connection, const std::string& draft)
      : stub_(v1::MapEditService::NewStub(connection.channel())) {
    v1::WatchMapDraftRequest request;
    request.set_name(draft);
    context_.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    reader_ = stub_->WatchMapDraft(&context_, request);
  }
  ~DraftStream() {
    context_.TryCancel();
    reader_->Finish();
  }
  v1::WatchMapDraftResponse Receive() {
    return ReceiveUntil([](const v1::WatchMapDraftResponse&) { return true; });
  }
  // What one change brings about may come in several messages, and nothing new is told every 10 s.
  template <typename IsWanted>
  v1::WatchMapDraftResponse ReceiveUntil(const IsWanted& is_wanted) {
    v1::WatchMapDraftResponse message;
    do {
      if (!reader_->Read(&message)) {
        ADD_FAILURE() << "the stream ended";
        return {};
      }
    } while (!is_wanted(message));
    return message;
  }

 private:
  std::unique_ptr<v1::MapEditService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::WatchMapDraftResponse>> reader_;
};

}  // namespace enfilade::testing
