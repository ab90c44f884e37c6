// SPDX-License-Identifier: Apache-2.0
import type { PriorMapChanges } from '../../../gen/enfilade/v1/prior_map_service_pb';
import { count } from '../../../ui/format';

// "2 walls added, 1 removed; 1 door added; another scale".
export function changesText(changes: Omit<PriorMapChanges, '$typeName' | '$unknown'> | undefined): string {
  if (!changes) return 'nothing';
  const counts = (noun: string, parts: [count: number, verb: string][]) =>
    parts.filter(([n]) => n > 0).map(([n, verb], i) => `${i === 0 ? count(n, noun) : n} ${verb}`).join(', ');
  const texts = [
    counts('wall', [[changes.wallsAdded, 'added'], [changes.wallsRemoved, 'removed'], [changes.wallsChanged, 'changed']]),
    counts('door', [[changes.doorsAdded, 'added'], [changes.doorsRemoved, 'removed']]),
    changes.scaleChanged ? 'another scale' : '',
  ];
  return texts.filter((text) => text !== '').join('; ') || 'nothing else than names or shafts';
}
