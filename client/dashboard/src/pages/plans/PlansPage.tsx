// SPDX-License-Identifier: Apache-2.0
import { idOf } from '../../api/names';
import { addressOf, Link, setQuery, usePlace } from '../../app/router';
import { useLevel } from '../../app/selection';
import type { PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import { useLive } from '../../live/context';
import { usePlans } from '../../live/plans';
import { Badge } from '../../ui/Badge';
import { DataTable, type Column } from '../../ui/DataTable';
import { byName, levelName } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';
import { ComparePage } from './ComparePage';
import { EditPage } from './editing/EditPage';
import { ImportForm } from './ImportForm';
import { PairsPage } from './PairsPage';
import { PlanPage } from './PlanPage';
import { isAligned, isPicture, modelName, share, stateOfPlan } from './plans';

const POLL_MS = 10_000;

const columnsOf = (site: string): Column<PriorMap>[] => [
  { title: 'Name', order: ({ displayName }) => displayName, cell: ({ name, displayName }) => <Link href={addressOf(site, 'plans', [idOf(name)])}>{displayName}</Link> },
  { title: 'Level', order: ({ level }) => level, cell: ({ level }) => levelName(level) },
  {
    title: 'State', order: ({ state }) => state,
    cell: ({ state, reason }) => (
      <>
        <Badge tone={stateOfPlan[state][0]}>{stateOfPlan[state][1]}</Badge> <span className="sub">{reason}</span>
      </>
    ),
  },
  { title: 'Walls', number: true, order: ({ elements }) => elements?.walls ?? 0, cell: ({ elements }) => elements?.walls ?? 0 },
  { title: 'Doors', number: true, order: ({ elements }) => elements?.doors ?? 0, cell: ({ elements }) => elements?.doors ?? 0 },
  { title: 'Rooms', number: true, order: ({ elements }) => elements?.rooms ?? 0, cell: ({ elements }) => elements?.rooms ?? 0 },
  { title: 'Explained', number: true, order: ({ alignment }) => alignment?.explained ?? -1, cell: ({ alignment }) => share(alignment?.explained) },
  { title: 'Contradicted', number: true, order: ({ alignment }) => alignment?.contradicted ?? -1, cell: ({ alignment }) => share(alignment?.contradicted) },
  { title: 'Model', cell: ({ alignment }) => (alignment ? `${modelName[alignment.model]}${alignment.mirrored ? ', mirrored' : ''}` : '–') },
];

function PlanTable({ plans }: { plans: PriorMap[] }) {
  const live = useLive();
  const level = useLevel();
  const rows = plans.filter((plan) => level === undefined || plan.level === level).sort((a, b) => a.level - b.level || byName(a.displayName, b.displayName));
  if (rows.length === 0) {
    return (
      <Empty title={level === undefined ? 'No plans yet' : 'No plans of this level'}>
        A floor plan or an emergency plan says where walls are before any robot has been there. Import one above; then let it be aligned with the maps of its level.
      </Empty>
    );
  }
  return (
    <DataTable caption="Plans" noun={['plan', 'plans']} rows={rows} columns={columnsOf(live.id)} keyOf={({ name }) => name}
      textOf={({ name, displayName, state, reason }) => `${idOf(name)} ${displayName} ${stateOfPlan[state][1]} ${reason}`} />
  );
}

// Floor plans, and where they lie in the world.
export default function PlansPage() {
  const live = useLive();
  const { rest, query } = usePlace();
  const { data, error, refetch } = usePlans(live.id, POLL_MS);
  const isImporting = query.has('import');
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (rest[0] !== undefined) {
    const plan = data.find(({ name }) => idOf(name) === rest[0]);
    if (plan && rest[1] === 'walls') return <EditPage key={rest[0]} plan={plan} />;
    if (plan && rest[1] === 'compare' && isAligned(plan)) return <ComparePage key={rest[0]} plan={plan} />;
    if (plan && rest[1] === 'points' && isPicture(plan)) return <PairsPage key={rest[0]} plan={plan} />;
    return <PlanPage key={rest[0]} plan={plan} />;
  }
  return (
    <div className="page">
      <div className="page-head">
        <h1>Plans</h1>
        <span className="space" />
        <button className="button" aria-expanded={isImporting} onClick={() => setQuery({ import: isImporting ? undefined : '1' })}>
          Import a plan
        </button>
      </div>
      {isImporting && <ImportForm />}
      <PlanTable plans={data} />
    </div>
  );
}
