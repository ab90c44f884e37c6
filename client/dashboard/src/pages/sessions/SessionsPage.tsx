// SPDX-License-Identifier: Apache-2.0
import { usePlace } from '../../app/router';
import { useLive } from '../../live/context';
import { Empty, Failed, Loading } from '../../ui/States';
import { SessionPage } from './SessionPage';
import { SessionTable, useSessions } from './SessionTable';

function Sessions() {
  const live = useLive();
  const { data, error, refetch } = useSessions();
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (data.length === 0) {
    return (
      <Empty title="No sessions yet" command={`enfilade --site ${live.id} replay LOG --map Hall --robot r1 --wait`}>
        A session is one drive of a robot: its scans and images, in their order. Robots begin sessions by themselves; the
        command sends a recorded drive.
      </Empty>
    );
  }
  return <SessionTable rows={data} />;
}

export default function SessionsPage() {
  const { rest } = usePlace();
  if (rest[0] !== undefined) return <SessionPage id={rest[0]} />;
  return (
    <div className="page">
      <div className="page-head">
        <h1>Sessions</h1>
      </div>
      <Sessions />
    </div>
  );
}
