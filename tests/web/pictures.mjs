// SPDX-License-Identifier: Apache-2.0
// The pictures of README.md and docs/web.md, and what a page must still have for its picture to be true.
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { settled } from './browser.mjs';
import { introduce, lookAt, stored } from './editing.mjs';
import { Robots } from './robots.mjs';

export const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
export const folder = 'docs/images/dashboard';
export const structuresFile = join(root, folder, 'structures.json');
export const viewport = { width: 1280, height: 800 };

const idOf = (name) => name.split('/').pop();

// The session of which most is to be seen: its passage through a door was compared with the most link points.
async function sessionToShow(system) {
  const { sessions } = await system.call('sites/demo/sessions');
  const compared = [];
  for (const { name } of sessions) {
    const { verdicts = [] } = await system.call(`${name}/doorVerdicts`);
    compared.push([verdicts.reduce((sum, { comparisons = [] }) => sum + comparisons.length, 0), idOf(name)]);
  }
  return compared.reduce((a, b) => (b[0] > a[0] ? b : a))[1];
}

// The newest optimisation that placed a map elsewhere than the last one did.
async function placingToShow(system) {
  const { graphVersions } = await system.call('sites/demo/graphVersions?pageSize=1000');
  const [last, ...earlier] = graphVersions.filter(({ cause }) => cause === 'CAUSE_OPTIMIZED').slice(0, 50).map(({ graphVersion }) => graphVersion);
  const placesOf = async (version) => (await system.call(`sites/demo/graphVersions/${version}/placedMaps`)).placedMaps;
  const now = new Map((await placesOf(last)).map(({ map, poseWorldMap }) => [map, poseWorldMap.pose]));
  const isElsewhere = ({ map, poseWorldMap: { pose: { x = 0, y = 0 } } }) => now.has(map) && Math.hypot((now.get(map).x ?? 0) - x, (now.get(map).y ?? 0) - y) > 0.01;
  for (const version of earlier) if ((await placesOf(version)).some(isElsewhere)) return version;
  throw new Error('no optimisation has moved a map');
}

// Two corners of the hall with their places on the globe, as a person would enter them.
async function georeference(system, map) {
  const controlPoints = [{ map, x: 0, y: 0, latitude: 50.7744, longitude: 6.0786 }, { map, x: 8, y: 6, latitude: 50.77445393, longitude: 6.07871346 }];
  const answer = await fetch(`${system.url}/v1/sites/demo/georeference`, {
    method: 'PUT', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ controlPoints }),
  });
  if (!answer.ok) throw new Error(await answer.text());
}

// A draft of the hall in which a pillar is erased and glass is drawn, beside an area.
async function draftOf(system, map) {
  const outline = { corners: [{ x: -4, y: -14 }, { x: 3, y: -18 }, { x: 5, y: -14.5 }, { x: -2, y: -10.5 }] };
  await system.call(`${map}/areas`, { displayName: 'Loading zone', kind: 'KIND_KEEP_OUT', outline, robotTypes: ['cleaner'] });
  const { draft } = await system.call(`${map}/drafts`, { displayName: 'Glass wall', author: 'Ann' });
  const { poseMapLattice: { x: x0 = 0, y: y0 = 0 } = {}, resolutionM } = draft.lattice;
  const units = (metres) => Math.round((256 * metres) / resolutionM);
  const edit = (number, radius, points, how) => ({
    editId: `00000000-0000-4000-8000-00000000000${number}`, author: 'Ann', ...how, brush: { points: points.map(([x, y]) => ({ x: units(x - x0), y: units(y - y0) })), radius: units(radius) },
  });
  await system.call(`${draft.name}:append`, {
    edits: [edit(1, 0.8, [[-9.2, -5.9], [-8.4, -5.7]], { value: 'VALUE_FREE' }), edit(2, 0.1, [[-20, -3], [-12.2, -7.5]], { value: 'VALUE_OCCUPIED', invisible: true })],
  });
  const [column, row] = [(-9 - x0) / resolutionM, (-10 - y0) / resolutionM];
  return { name: draft.name, column, row };
}

// The pages by the names of their pictures. `prepare`: what a person does there first.
export async function picturesOf(system) {
  const { maps } = await system.call('sites/demo/maps');
  const hallName = maps.find(({ displayName }) => displayName === 'Hall').name;
  const hall = idOf(hallName);
  await georeference(system, hallName);
  const session = await sessionToShow(system);
  const placing = await placingToShow(system);
  const draft = await draftOf(system, hallName);
  const openDraft = async (page) => {
    await introduce(page, 'Ann');
    await stored(page);
    await lookAt(page, draft.column, draft.row, 1.1);
    await stored(page);
  };
  const path = (rest) => `${system.url}/s/demo/${rest}`;
  return {
    campus: { url: path('campus'), theme: 'light' },
    'campus-dark': { url: path('campus?sel=robots%2Fr1'), theme: 'dark' },
    maps: { url: path('maps'), theme: 'light' },
    map: { url: path(`maps/${hall}`), theme: 'light' },
    editor: { url: path(`maps/${hall}/edit/${idOf(draft.name)}`), theme: 'light', prepare: openDraft },
    'link-points': { url: path('linkPoints'), theme: 'light' },
    robots: { url: path('robots'), theme: 'light' },
    robot: { url: path('robots/r1'), theme: 'light' },
    sessions: { url: path('sessions'), theme: 'light' },
    session: { url: path(`sessions/${session}`), theme: 'light' },
    history: { url: path(`history?from=${placing}`), theme: 'light' },
    versions: { url: path('history/versions'), theme: 'light' },
    audit: { url: path('history/audit'), theme: 'light' },
    georeference: { url: path('georeference'), theme: 'light' },
    health: { url: path('health'), theme: 'light' },
  };
}

// Lets the robots of the campus say where they stand, until the returned function is called: the pictures show live robots.
export async function standing(system, names) {
  const robots = new Robots(system, 'demo');
  const reports = [];
  for (const name of names) {
    const { globalPose } = await system.call(`sites/demo/robots/${name}/globalPose`);
    const { map, poseMapRobot } = globalPose.mapPose;
    const id = idOf(map);
    await robots.begin(name, id);
    reports.push(() => robots.report(name, id, poseMapRobot.pose, poseMapRobot.covariance));
  }
  const report = () => reports.forEach((one) => one());
  report();
  const timer = setInterval(report, 1000);
  return () => {
    clearInterval(timer);
    robots.close();
  };
}

export async function show(page, { url, theme, prepare = async () => {} }) {
  await page.emulateMedia({ colorScheme: theme, reducedMotion: 'reduce' });
  await page.goto(url);
  await settled(page);
  await prepare(page);
}

// What a page consists of, without what depends on the campus: landmarks, headings, controls and columns, in their order.
// Digits and ids are #, so that counts and times do not matter.
export function structureOf(page) {
  return page.evaluate(() => {
    const parts = 'header, nav, main, aside, h1, h2, h3, th, button, select, input, summary, [role=tab], [role=toolbar], nav a, section[aria-label]';
    const nameOf = (element) =>
      (element.getAttribute('aria-label') ?? (element.matches('header, nav, main, aside, section, select, [role=toolbar]') ? '' : element.textContent)).trim().replace(/\b[0-9a-f]{8}\b|\d+/g, '#');
    const shown = [...document.querySelectorAll(parts)].filter((element) => !element.closest('tbody, [role=listbox], ul, ol, dl, [hidden]'));
    return [...new Set(shown.map((element) => `${element.tagName.toLowerCase()} ${nameOf(element)}`.trim()))];
  });
}

export const storedStructures = () => JSON.parse(readFileSync(structuresFile, 'utf8'));
