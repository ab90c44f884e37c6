// SPDX-License-Identifier: Apache-2.0
// A browser's EventSource hears of each change of a site exactly once, whatever is killed meanwhile.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { open } from './browser.mjs';
import { setStage } from './stage.mjs';
import { until } from './system.mjs';

const { system, browser } = setStage();

// The pages' bare address has no icon; the rest is what a browser says of a server that is away.
const excused = { expected: /Failed to load resource|EventSource|ERR_/ };

// Runs in the page. A client as the documentation says: it goes on from the last token, opens anew when the browser has
// given up, and forgets what it knows when it is told to.
function listen(site) {
  const client = { token: '', messages: 0, resets: 0, opened: 0, told: {}, maps: {}, linkPoints: {}, sessions: {}, paused: false };
  window.client = client;
  const count = (name) => (client.told[name] = (client.told[name] ?? 0) + 1);
  const take = (message) => {
    client.messages++;
    if (message.start?.reset) {
      client.resets++;
      Object.assign(client, { told: {}, maps: {}, linkPoints: {}, sessions: {} });
    }
    const { removedMaps = [], removedLinkPoints = [], maps = [], linkPoints = [] } = message.graph ?? {};
    for (const name of removedMaps) delete client.maps[name];
    for (const name of removedLinkPoints) delete client.linkPoints[name];
    for (const map of maps) count(map.map), (client.maps[map.map] = map);
    for (const point of linkPoints) count(point.linkPoint), (client.linkPoints[point.linkPoint] = point);
    for (const name of message.removedSessions ?? []) delete client.sessions[name];
    for (const session of message.sessions ?? []) client.sessions[session.session] = session.state;
    client.token = message.resumeToken ?? client.token;
  };
  const connect = () => {
    if (client.paused) return setTimeout(connect, 50);
    const source = new EventSource(`/v1/sites/${site}:watch?rateHz=20&resumeToken=${encodeURIComponent(client.token)}`);
    source.onopen = () => client.opened++;
    source.onmessage = ({ data }) => take(JSON.parse(data));
    source.onerror = () => {
      if (source.readyState === EventSource.CLOSED) setTimeout(connect, 200);
    };
  };
  connect();
}

const stateOf = (page) => page.evaluate(() => window.client);
const sorted = (names) => [...names].sort();

// Repeats a call until it is answered; the request id makes it happen once.
const insist = (path, body) => until(path, () => system.call(path, body).catch(() => undefined));

// Makes a change of each kind: another map, a link point in it, a session.
async function change(site, number) {
  const id = `n${number}`;
  await insist(`sites/${site}/maps?mapId=${id}&requestId=map-${id}`, { displayName: id });
  const anchor = { map: `sites/${site}/maps/${id}`, poseMapPlace: { pose: { x: number } } };
  await insist(`sites/${site}/linkPoints?linkPointId=${id}&requestId=point-${id}`, { kind: 'KIND_DOOR', anchors: [anchor] });
  await insist(`sites/${site}/sessions?sessionId=${id}&requestId=session-${id}`, { robot: `sites/${site}/robots/r1`, map: `sites/${site}/maps/${id}` });
}

// Waits until the page knows what the server knows, and nothing else.
async function agree(page, site, what) {
  const { graph } = await system.call(`sites/${site}/graph`);
  const { sessions } = await system.call(`sites/${site}/sessions?pageSize=1000`);
  const names = (items, field) => sorted(items.map((item) => item[field]));
  const wanted = { maps: names(graph.maps, 'map'), linkPoints: names(graph.linkPoints, 'linkPoint'), sessions: names(sessions, 'name') };
  let known;
  await until(`the page knows all (${what})`, async () => {
    const state = await stateOf(page);
    known = Object.fromEntries(Object.keys(wanted).map((kind) => [kind, sorted(Object.keys(state[kind]))]));
    return JSON.stringify(known) === JSON.stringify(wanted);
  }).catch(() => assert.deepEqual(known, wanted, what));
}

const site = async (id) => {
  await system.call(`sites?siteId=${id}`, { displayName: id });
  await system.call(`sites/${id}/robots?robotId=r1`, { displayName: 'One' });
};

test('sse_resume: a site without robots answers at once, and shows that the stream lives', async (t) => {
  await site('quiet');
  const { page, close } = await open(browser(), `${system.url}/healthz`, excused);
  const begin = performance.now();
  await page.evaluate(listen, 'quiet');
  await page.waitForFunction(() => window.client.messages > 0, undefined, { polling: 10 });
  t.diagnostic(`the first event came after ${Math.round(performance.now() - begin)} ms`);
  const { messages } = await stateOf(page);
  await until('a heartbeat comes', async () => (await stateOf(page)).messages > messages);
  await close();
});

test('sse_resume: no change is lost or told twice while gateway and server are killed', async () => {
  await site('busy');
  const { page, close } = await open(browser(), `${system.url}/healthz`, excused);
  await page.evaluate(listen, 'busy');
  let number = 0;
  for (; number < 3; number++) await change('busy', number);
  await agree(page, 'busy', 'at first');

  // The gateway dies in the midst of changes: the browser goes on by Last-Event-ID.
  const changes = (async () => {
    for (const end = number + 10; number < end; number++) await change('busy', number);
  })();
  await system.kill('gateway');
  await system.startGateway();
  await changes;
  await agree(page, 'busy', 'after the gateway');
  const { resets, told } = await stateOf(page);
  assert.equal(resets, 1, 'the stream was resumed');
  assert.deepEqual(Object.entries(told).filter(([, times]) => times !== 1), [], 'each was told once');

  // The server dies, too, and nothing has changed when the page comes back.
  await system.kill('server');
  system.startServer();
  await system.ready();
  await until('the page is back', async () => (await stateOf(page)).opened > 2);
  await change('busy', number++);
  await agree(page, 'busy', 'after the server');
  const second = await stateOf(page);
  assert.equal(second.resets, 1, 'the stream was resumed');
  assert.deepEqual(Object.entries(second.told).filter(([, times]) => times !== 1), [], 'each was told once');

  // Both die, and much has changed when the page comes back: it may be told everything again, after a reset.
  await page.evaluate(() => (window.client.paused = true));
  await system.kill('server');
  await system.kill('gateway');
  system.startServer();
  await system.startGateway();
  await system.ready();
  for (const end = number + 3; number < end; number++) await change('busy', number);
  const remove = await fetch(`${system.url}/v1/sites/busy/linkPoints/n1`, { method: 'DELETE' });
  assert.equal(remove.status, 200);
  await page.evaluate(() => (window.client.paused = false));
  await agree(page, 'busy', 'after both');
  const third = await stateOf(page);
  assert.deepEqual(Object.entries(third.told).filter(([, times]) => times !== 1), [], 'each was told once');
  await close();
});
