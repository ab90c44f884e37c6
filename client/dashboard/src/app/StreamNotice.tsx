// SPDX-License-Identifier: Apache-2.0
import { useLive, useNow } from '../live/context';
import { Badge, Shape } from '../ui/Badge';
import { clock } from '../ui/format';

// In the bar: one word on the stream.
export function StreamBadge() {
  const { state } = useLive();
  const [tone, word] =
    state.kind === 'live' ? (['good', 'Live'] as const)
    : state.kind === 'connecting' ? (['quiet', 'Connecting'] as const)
    : state.kind === 'lost' ? (['warn', 'Not live'] as const)
    : (['bad', 'Stopped'] as const);
  return (
    <span className="stream" title={word} role="status">
      <Badge tone={tone}>
        <span className="label">{word}</span>
      </Badge>
    </span>
  );
}

// Under the bar while the stream is lost: what is shown stays, and says how old it is.
export function StreamNotice() {
  const { state, complete } = useLive();
  const now = useNow(500);
  if (state.kind !== 'lost') return null;
  const seconds = Math.max(0, Math.ceil((state.retryAt - now) / 1000));
  const what = complete ? `Not live since ${clock(state.since)}. You see the last known state` : 'The site cannot be loaded';
  return (
    <div className="notice" role="status">
      <Shape tone="warn" />
      <span>
        {what}: {state.reason}. {seconds > 0 ? `Next attempt in ${seconds} s.` : 'Connecting …'}
      </span>
    </div>
  );
}
