// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { server } from '../../api/clients';
import { gatewayStatus, type GatewayStatus } from '../../api/gateway';
import { useLive } from '../../live/context';
import type { LiveSite } from '../../live/site';
import type { GetServerStatusResponse } from '../../gen/enfilade/v1/server_service_pb';
import { Badge, type Tone } from '../../ui/Badge';
import { CopyButton } from '../../ui/CopyButton';
import { age, count } from '../../ui/format';
import { Failed, Loading } from '../../ui/States';

interface Check {
  what: string;
  tone: Tone;
  value: string;
  // What to do if it is not well.
  remedy?: string;
}

// Mapping that waits longer needs more servers, or has stopped.
const LAG_S = 60;

// Answers that clients do not take whole, and errors: single ones are nobody's fault.
const MANY = 0.01;

function gatewayCheck({ uptimeS, openRequests, requests, serverErrors, cutAnswers }: GatewayStatus): Check {
  const value = `up for ${age(uptimeS)}, ${count(openRequests, 'request')} open, ${count(requests, 'answer')}: ${serverErrors} failed, ${cutAnswers} cut`;
  const failing = serverErrors > 10 && serverErrors > MANY * requests;
  return failing ? { what: 'Gateway', tone: 'warn', value, remedy: 'Look for status 5xx in the gateway’s log; its request ids are in the server’s log, too.' } : { what: 'Gateway', tone: 'good', value };
}

function checksOf(status: GetServerStatusResponse, gateway: GatewayStatus, site: LiveSite): Check[] {
  const current = status.schemaVersion === status.expectedSchemaVersion;
  const lag = Number(site.health?.mappingLag?.seconds ?? 0n);
  const apart = site.health?.disconnectedMaps ?? 0;
  return [
    status.ready
      ? { what: 'Server', tone: 'good', value: `version ${status.version}, up for ${age(Number(status.uptime?.seconds ?? 0n))}` }
      : { what: 'Server', tone: 'bad', value: status.notReadyReason, remedy: 'The reason names what is missing; the server’s log has more.' },
    current
      ? { what: 'Database', tone: 'good', value: `migration ${status.schemaVersion}` }
      : { what: 'Database', tone: 'warn', value: `migration ${status.schemaVersion}, the server knows ${status.expectedSchemaVersion}`, remedy: 'Migrate the database, or update the server: see docs/database.md.' },
    gatewayCheck(gateway),
    site.state.kind === 'live'
      ? { what: 'Live stream', tone: 'good', value: 'open' }
      : { what: 'Live stream', tone: 'warn', value: 'not open', remedy: 'It opens again by itself. If it does not, look at the gateway’s log.' },
    lag <= LAG_S
      ? { what: 'Mapping', tone: 'good', value: lag === 0 ? 'nothing waits' : `the oldest record has waited ${age(lag)}` }
      : { what: 'Mapping', tone: 'warn', value: `the oldest record has waited ${age(lag)}`, remedy: 'Start another server, or see which session has failed.' },
    apart === 0
      ? { what: 'Maps', tone: 'good', value: 'all are joined to the root' }
      : { what: 'Maps', tone: 'warn', value: `${count(apart, 'map is', 'maps are')} not joined to the root`, remedy: 'Drive a robot through a door between them, or place a link point.' },
    { what: 'Work now', tone: 'quiet', value: `${count(status.sessionsMapping, 'session')} being mapped, ${count(status.streamsOpen, 'robot')} streaming to this server` },
  ];
}

const reportOf = (site: LiveSite, checks: Check[]) =>
  [`Enfilade, site ${site.id}, ${new Date().toISOString()}`, ...checks.map(({ what, value }) => `${what}: ${value}`), `Graph: version ${site.graphVersion}`].join('\n');

export default function HealthPage() {
  const live = useLive();
  const { data, error, refetch } = useQuery({
    queryKey: ['status'], refetchInterval: 5000,
    queryFn: async () => ({ server: await server.getServerStatus({}), gateway: await gatewayStatus() }),
  });
  const checks = data && checksOf(data.server, data.gateway, live);
  return (
    <div className="page">
      <div className="page-head">
        <h1>Health</h1>
        <span className="space" />
        {checks && <CopyButton text={reportOf(live, checks)} what="report" />}
      </div>
      {error ? (
        <Failed error={error} retry={() => void refetch()} />
      ) : !checks ? (
        <Loading />
      ) : (
        <dl className="facts card padded health">
          {checks.map(({ what, tone, value, remedy }) => (
            <div key={what} className="fact">
              <dt>{what}</dt>
              <dd>
                <Badge tone={tone}>{value}</Badge>
                {remedy !== undefined && <p className="sub">{remedy}</p>}
              </dd>
            </div>
          ))}
        </dl>
      )}
    </div>
  );
}
