// SPDX-License-Identifier: Apache-2.0
#include "core/doors/door_track.h"

#include "core/geometry/pose_codec.h"

namespace enfilade::doors {

void PutTrack(BinaryWriter& writer, const DoorTrack& track) {
  for (const double value : {track.narrows.left.x(), track.narrows.left.y(), track.narrows.right.x(),
                             track.narrows.right.y(), track.narrows.along, track.narrows.depth, track.crossed_at}) {
    writer.Put(value);
  }
  writer.Put<std::int32_t>(track.hits);
  writer.Put<std::int32_t>(track.weight);
  writer.Put(track.last_hit);
  writer.Put(track.door);
  writer.Put<std::uint8_t>(track.reported);
  writer.Put(track.latch_time);
  PutPose(writer, track.T_odom_latch);
}

DoorTrack GetTrack(BinaryReader& reader) {
  DoorTrack track;
  for (double* value : {&track.narrows.left.x(), &track.narrows.left.y(), &track.narrows.right.x(),
                        &track.narrows.right.y(), &track.narrows.along, &track.narrows.depth, &track.crossed_at}) {
    *value = reader.Get<double>();
  }
  track.hits = reader.Get<std::int32_t>();
  track.weight = reader.Get<std::int32_t>();
  track.last_hit = reader.Get<TimeNs>();
  track.door = reader.Get<std::int64_t>();
  track.reported = reader.Get<std::uint8_t>() != 0;
  track.latch_time = reader.Get<TimeNs>();
  track.T_odom_latch = GetPose(reader);
  return track;
}

}  // namespace enfilade::doors
