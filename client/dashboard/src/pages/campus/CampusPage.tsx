// SPDX-License-Identifier: Apache-2.0
import './campus.css';
import { useLevel } from '../../app/selection';
import { useLive } from '../../live/context';
import { Empty, Loading } from '../../ui/States';
import { ObjectList } from './ObjectList';
import { UnplacedTray } from './UnplacedTray';

const everywhere = () => true;

export default function CampusPage() {
  const live = useLive();
  const level = useLevel();
  if (!live.complete) return <Loading />;
  if (live.maps.size === 0) {
    return (
      <Empty title="This site has no maps yet" command={`enfilade robot --site ${live.id} --campus figure1 --map Hall`}>
        Maps appear here as robots make them. Start one, or let the simulator drive; files of other programs are imported by “enfilade map import”.
      </Empty>
    );
  }
  return (
    <div className="campus">
      <aside className="panel">
        <UnplacedTray level={level} />
        <ObjectList level={level} inView={everywhere} />
      </aside>
    </div>
  );
}
