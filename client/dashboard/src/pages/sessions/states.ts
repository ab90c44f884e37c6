// SPDX-License-Identifier: Apache-2.0
import { Closure_State } from '../../gen/enfilade/v1/closure_pb';
import { DoorVerdict_Decision } from '../../gen/enfilade/v1/door_pb';
import { Session_State } from '../../gen/enfilade/v1/session_pb';
import type { Tone } from '../../ui/Badge';

export const stateOfSession: Record<Session_State, [Tone, string]> = {
  [Session_State.UNSPECIFIED]: ['quiet', 'Unknown'],
  [Session_State.RECORDING]: ['good', 'Recording'],
  [Session_State.FINISHED]: ['warn', 'Being mapped'],
  [Session_State.MAPPED]: ['good', 'Mapped'],
  [Session_State.FAILED]: ['bad', 'Failed'],
};

export const stateOfClosure: Record<Closure_State, [Tone, string]> = {
  [Closure_State.UNSPECIFIED]: ['quiet', 'Unknown'],
  [Closure_State.ACCEPTED]: ['good', 'Accepted'],
  [Closure_State.REJECTED]: ['bad', 'Rejected'],
  [Closure_State.SUSPENDED]: ['quiet', 'Suspended'],
};

export const decisions: Record<DoorVerdict_Decision, string> = {
  [DoorVerdict_Decision.UNSPECIFIED]: 'Unknown',
  [DoorVerdict_Decision.CANDIDATE_MADE]: 'New candidate',
  [DoorVerdict_Decision.CANDIDATE_KNOWN]: 'Known candidate',
  [DoorVerdict_Decision.CANDIDATE_PROMOTED]: 'Candidate became a link point',
  [DoorVerdict_Decision.LINK_POINT_RECOGNISED]: 'Link point recognised',
  [DoorVerdict_Decision.LINK_POINT_MADE]: 'New link point',
  [DoorVerdict_Decision.NOT_JUDGED]: 'Not judged',
};
