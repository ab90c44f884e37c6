// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { maps } from '../../api/clients';
import { idOf } from '../../api/names';
import type { MapRevision } from '../../gen/enfilade/v1/map_pb';
import { sharedScene } from '../../scene/shared';
import { count } from '../../ui/format';
import { Failed, Loading } from '../../ui/States';
import { diffLines, kindOf, middleOf, sizeOf } from './versions';

const SHOWN_REGIONS = 50;

interface Props {
  base: MapRevision;
  revision: MapRevision;
  chosen: number | undefined;
  choose: (region: number) => void;
}

// Never changes: revisions do not.
export function useDifference(base: MapRevision | undefined, revision: MapRevision) {
  return useQuery({
    queryKey: ['difference', base?.name, revision.name],
    enabled: base !== undefined,
    staleTime: Infinity,
    queryFn: () => maps.diffMapRevisions({ base: base!.name, revision: revision.name, maxRegions: SHOWN_REGIONS }),
  });
}

const square = (area: number) => `${area.toFixed(area < 10 ? 2 : 0)} m²`;

// What came and went between two revisions, in numbers, and where.
export function Differences({ base, revision, chosen, choose }: Props) {
  const { data, error, refetch } = useDifference(base, revision);
  const title = `From ${idOf(base.name)} to ${idOf(revision.name)}`;
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  const lines = diffLines(data);
  return (
    <section className="differences" aria-label="Differences">
      <h2>{title}</h2>
      {lines.length === 0 && <p className="sub">No cell has changed.</p>}
      <dl className="facts">
        {lines.map((line) => (
          <div key={line.title} className="difference">
            <dt>{line.title}</dt>
            <dd>
              {square(line.area)} <span className="sub">{count(line.cells, 'cell')}</span>
            </dd>
          </div>
        ))}
      </dl>
      {data.regions.length > 0 && (
        <>
          <p className="sub">
            {count(Number(data.regionCount), 'place')} {Number(data.regionCount) > data.regions.length ? `, the ${data.regions.length} largest:` : ''}
          </p>
          <ol className="regions">
            {data.regions.map((region, i) => {
              const at = middleOf(region);
              const [width, height] = sizeOf(region);
              return (
                <li key={i}>
                  <button className="region" aria-pressed={chosen === i} disabled={!at} onClick={() => { choose(i); if (at) sharedScene()?.centre(at); }}>
                    {kindOf(region)} <span className="sub">{width.toFixed(2)} × {height.toFixed(2)} m</span>
                  </button>
                </li>
              );
            })}
          </ol>
        </>
      )}
    </section>
  );
}
