// SPDX-License-Identifier: Apache-2.0
import './plans.css';
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { Fragment, useState, type ReactNode } from 'react';
import { problemOf } from '../../api/errors';
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { PriorMap_State, type PriorAlignment, type PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { isPlaced } from '../../live/plans';
import { Badge } from '../../ui/Badge';
import { dateTime, levelName } from '../../ui/format';
import { FileLinks, filesAt } from '../../ui/FileLinks';
import { Empty } from '../../ui/States';
import { Actions } from './Actions';
import { elementsText, fileOf, modelName, share, stateOfPlan } from './plans';

function Facts({ facts }: { facts: [title: string, value: ReactNode][] }) {
  return (
    <dl className="card facts padded">
      {facts.map(([title, value]) => (
        <div key={title} className="fact">
          <dt>{title}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}

function MapLinks({ maps }: { maps: string[] }) {
  const live = useLive();
  return maps.map((map, i) => (
    <Fragment key={map}>
      {i > 0 && ', '}
      <Link href={addressOf(live.id, 'maps', [idOf(map)])}>{titleOf(live, map)}</Link>
    </Fragment>
  ));
}

// A plan that was corrected since it was aligned has none.
function Picture({ plan }: { plan: PriorMap }) {
  const { data } = useQuery({ queryKey: ['files', plan.name, plan.etag], staleTime: Infinity, queryFn: () => filesAt(`/v1/${plan.name}/files`) });
  if (!data?.some(({ name }) => name === 'fit.png')) return null;
  return (
    <img className="card plan-picture" src={`${fileOf(plan.name, 'fit.png', 'picture')}&etag=${encodeURIComponent(plan.etag)}`}
      alt="The maps, the plan as it was placed, and corrected: walls that were seen green, others blue, contradicted ones red" />
  );
}

function Alignment({ alignment, plan }: { alignment: PriorAlignment; plan: PriorMap }) {
  return (
    <>
      <h2>{plan.state === PriorMap_State.NEW ? 'Alignment before it was corrected' : 'Alignment'}</h2>
      <Facts facts={[
        ['Model', `${modelName[alignment.model]}${alignment.mirrored ? ', mirrored' : ''}`],
        ['Explained', `${share(alignment.explained)} of the walls that robots have seen lie on walls of the plan`],
        ['Contradicted', `${share(alignment.contradicted)} of the plan’s walls are where robots have seen none`],
        ['Against the best other place', alignment.rivalRatio > 0 ? `${alignment.rivalRatio.toFixed(2)} times as good` : 'people showed the place'],
        ['Pairs that people showed', alignment.pairs.length],
        ['Maps', <MapLinks key="maps" maps={alignment.maps} />],
        ['Ties', `${alignment.tiedWalls} times a map has seen a wall of the plan`],
        ...(alignment.joinedMaps.length > 0
          ? [['Joined by the plan alone', <MapLinks key="joined" maps={alignment.joinedMaps} />] as [string, ReactNode]] : []),
        ['Made', alignment.alignTime ? dateTime(timestampMs(alignment.alignTime)) : '–'],
      ]} />
      <Picture plan={plan} />
    </>
  );
}

// The server renders the files when they are asked for, so they are listed only then.
function Files({ plan }: { plan: PriorMap }) {
  const [open, setOpen] = useState(false);
  const { data, error, isFetching } = useQuery({
    queryKey: ['files', plan.name, plan.etag], enabled: open, staleTime: Infinity, queryFn: () => filesAt(`/v1/${plan.name}/files`),
  });
  return (
    <details className="plan-files" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>Download</summary>
      {isFetching && <p className="sub">Rendering …</p>}
      {error && <p className="sub">{problemOf(error).text}</p>}
      <FileLinks files={data} />
    </details>
  );
}

// One plan: its state, where it lies, and what can be done with it. Undefined: there is none of this name.
export function PlanPage({ plan }: { plan: PriorMap | undefined }) {
  const live = useLive();
  if (!plan) {
    return (
      <Empty title="This plan does not exist">
        It may have been deleted. <Link href={addressOf(live.id, 'plans')}>All plans of this site</Link>
      </Empty>
    );
  }
  const [tone, state] = stateOfPlan[plan.state];
  return (
    <div className="page">
      <div className="page-head">
        <h1>{plan.displayName}</h1>
      </div>
      <Actions plan={plan} />
      <Facts facts={[
        ['State', <Badge key="state" tone={tone}>{state}</Badge>],
        ['Why', plan.reason === '' ? '–' : plan.reason],
        ['Level', <Fragment key="level">{levelName(plan.level)}{isPlaced(plan) && <> · <Link href={addressOf(live.id, 'campus', [], { l: String(plan.level) })}>Show on the campus</Link></>}</Fragment>],
        ['File', plan.fileName],
        ['Found in it', elementsText(plan.elements)],
        ['Scale', plan.elements && plan.elements.metresPerUnit > 0 ? `${plan.elements.metresPerUnit.toPrecision(4)} m per unit` : 'unknown: measure a distance under “Correct walls”'],
        ['Imported', plan.createTime ? dateTime(timestampMs(plan.createTime)) : '–'],
      ]} />
      {plan.warnings.length > 0 && (
        <>
          <h2>Noticed while the file was read</h2>
          <ul aria-label="Warnings">
            {plan.warnings.map((warning) => (
              <li key={warning}>{warning}</li>
            ))}
          </ul>
        </>
      )}
      {plan.alignment && <Alignment alignment={plan.alignment} plan={plan} />}
      <Files plan={plan} />
    </div>
  );
}
