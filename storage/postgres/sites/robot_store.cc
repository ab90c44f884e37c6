// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/robot_store.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;

#define ENFILADE_ROBOT_COLUMNS "site_id, robot_id, display_name, etag, create_time, update_time"

constexpr Statement kInsertRobot{
    "creating the robot",
    "INSERT INTO enfilade.robots (site_id, robot_id, display_name, request_id, request_sha256)"
    " VALUES ($1, $2, $3, $4, $5) RETURNING " ENFILADE_ROBOT_COLUMNS};
constexpr Statement kFindRobotRequest{"looking for an earlier request",
                                      "SELECT " ENFILADE_ROBOT_COLUMNS ENFILADE_SAME_REQUEST(
                                          "$3") " FROM enfilade.robots WHERE site_id = $1 AND request_id = $2"};
constexpr Statement kSelectRobot{
    "reading the robot", "SELECT " ENFILADE_ROBOT_COLUMNS " FROM enfilade.robots WHERE site_id = $1 AND robot_id = $2"};
constexpr Statement kListRobots{"listing robots", "SELECT " ENFILADE_ROBOT_COLUMNS
                                                  " FROM enfilade.robots WHERE site_id = $1 AND robot_id > $2"
                                                  " ORDER BY robot_id LIMIT $3"};
constexpr Statement kUpdateRobot{"updating the robot",
                                 "UPDATE enfilade.robots SET display_name = $4, etag = $5,"
                                 " update_time = now() WHERE site_id = $1 AND robot_id = $2 AND etag = $3"
                                 " RETURNING " ENFILADE_ROBOT_COLUMNS};
constexpr Statement kDeleteRobot{
    "deleting the robot", "DELETE FROM enfilade.robots WHERE site_id = $1 AND robot_id = $2 AND ($3 = 0 OR etag = $3)"};

Robot ReadRobot(Row& row) {
  Robot robot;
  robot.site = SiteId(std::string(row.Text()));
  robot.id = RobotId(std::string(row.Text()));
  robot.display_name = row.Text();
  robot.etag = row.Int64();
  robot.create_time = row.Time();
  robot.update_time = row.Time();
  return robot;
}

absl::Status Explain(const absl::Status& status, const Robot& robot) {
  if (absl::IsAlreadyExists(status)) return AlreadyExists("{} exists already", NameOf(robot.site, robot.id));
  if (absl::IsFailedPrecondition(status) && postgres::SqlStateOf(status) == "23503") {
    return NotFound("{} does not exist", NameOf(robot.site));
  }
  return WithContext(status, NameOf(robot.site, robot.id));
}

}  // namespace

absl::StatusOr<Robot> RobotStore::Create(const CallContext& context, const Robot& robot,
                                         const RequestId& request_id) const {
  const auto inserted =
      storage::postgres::ExecuteAlone(pool_, context, kInsertRobot,
                                      Params(robot.site, robot.id, robot.display_name, postgres::IdOrNull(request_id),
                                             postgres::DigestOrNull(request_id)));
  if (inserted.ok()) return storage::postgres::ReadOne(*inserted, ReadRobot, NameOf(robot.site, robot.id));
  if (absl::IsAlreadyExists(inserted.status()) && !request_id.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(
        const auto earlier,
        storage::postgres::ExecuteAlone(pool_, context, kFindRobotRequest,
                                        Params(robot.site, request_id.value, postgres::DigestOrNull(request_id))));
    if (earlier.rows() > 0) return storage::postgres::ReadRequested(earlier, ReadRobot, NameOf(robot.site, robot.id));
  }
  return Explain(inserted.status(), robot);
}

absl::StatusOr<Robot> RobotStore::Get(const CallContext& context, const SiteId& site, const RobotId& robot) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kSelectRobot, Params(site, robot)));
  return storage::postgres::ReadOne(result, ReadRobot, NameOf(site, robot));
}

absl::StatusOr<std::vector<Robot>> RobotStore::List(const CallContext& context, const SiteId& site,
                                                    const PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, storage::postgres::ExecuteAlone(
                                                   pool_, context, kListRobots,
                                                   Params(site, page.after, static_cast<std::int64_t>(page.limit))));
  return storage::postgres::ReadRows(result, ReadRobot);
}

absl::StatusOr<Robot> RobotStore::Update(const CallContext& context, const Robot& robot) const {
  const auto updated = storage::postgres::ExecuteAlone(
      pool_, context, kUpdateRobot, Params(robot.site, robot.id, robot.etag, robot.display_name, postgres::NewEtag()));
  if (!updated.ok()) return Explain(updated.status(), robot);
  if (updated->rows() > 0) return storage::postgres::ReadOne(*updated, ReadRobot, NameOf(robot.site, robot.id));
  ENFILADE_RETURN_IF_ERROR(Get(context, robot.site, robot.id).status());
  return postgres::StaleEtag(NameOf(robot.site, robot.id));
}

absl::Status RobotStore::Delete(const CallContext& context, const SiteId& site, const RobotId& robot,
                                std::int64_t etag) const {
  const auto deleted = storage::postgres::ExecuteAlone(pool_, context, kDeleteRobot, Params(site, robot, etag));
  if (absl::IsFailedPrecondition(deleted.status()) && postgres::SqlStateOf(deleted.status()) == "23503") {
    return FailedPrecondition("{} still has sessions: delete them first", NameOf(site, robot));
  }
  if (!deleted.ok()) return WithContext(deleted.status(), NameOf(site, robot));
  if (deleted->affected() > 0) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(Get(context, site, robot).status());
  return postgres::StaleEtag(NameOf(site, robot));
}

}  // namespace enfilade::storage
