// SPDX-License-Identifier: Apache-2.0
// What a page's scripts take, frame by frame, by Chromium's own trace. The software renderer of a machine without a graphics
// card makes calls of WebGL wait, and other programs take the processor away: the processor's time of the page's thread is
// told apart from the time that passed.

const quantile = (values, share) => [...values].sort((a, b) => a - b)[Math.floor(values.length * share)];
const round = (ms) => Math.round(100 * ms) / 100;
const spread = (values) => ({ p50_ms: round(quantile(values, 0.5)), p95_ms: round(quantile(values, 0.95)), max_ms: round(Math.max(...values)) });
const LONG_MS = 50;

// What the page's main thread did meanwhile.
async function traced(page, act) {
  const session = await page.context().newCDPSession(page);
  const events = [];
  session.on('Tracing.dataCollected', ({ value }) => events.push(...value));
  const complete = new Promise((resolve) => session.once('Tracing.tracingComplete', resolve));
  await session.send('Tracing.start', { traceConfig: { includedCategories: ['devtools.timeline', 'toplevel'], excludedCategories: ['*'] }, transferMode: 'ReportEvents' });
  await act();
  await session.send('Tracing.end');
  await complete;
  const frames = events.filter(({ name, tdur }) => name === 'FireAnimationFrame' && tdur !== undefined);
  const thread = frames[0]?.tid;
  const tasks = events.filter(({ name, tid, tdur }) => name === 'ThreadControllerImpl::RunTask' && tid === thread && tdur !== undefined);
  const long = (field) => tasks.filter((task) => task[field] / 1000 > LONG_MS).length;
  return {
    frames: frames.length,
    scripts: spread(frames.map(({ tdur }) => tdur / 1000)),
    scripts_with_waiting: spread(frames.map(({ dur }) => dur / 1000)),
    long_tasks: long('tdur'),
    long_tasks_with_waiting: long('dur'),
    longest_task_ms: round(Math.max(...tasks.map(({ tdur }) => tdur / 1000))),
  };
}

async function pan(page) {
  await page.mouse.move(500, 400);
  await page.mouse.down();
  for (let i = 0; i < 60; ++i) await page.mouse.move(500 + 3 * (i % 30), 400 + 2 * (i % 60));
  await page.mouse.up();
}

// Where a processor's time goes while the map is dragged, by function, ms a frame.
async function profile(page) {
  const session = await page.context().newCDPSession(page);
  await session.send('Profiler.enable');
  await session.send('Profiler.setSamplingInterval', { interval: 200 });
  const before = await page.evaluate(() => window.__scene.stats().frames);
  await session.send('Profiler.start');
  await pan(page);
  const { profile } = await session.send('Profiler.stop');
  const frames = (await page.evaluate(() => window.__scene.stats().frames)) - before;
  const byId = new Map(profile.nodes.map((node) => [node.id, node]));
  const self = new Map();
  profile.samples.forEach((id, i) => {
    const { functionName, url } = byId.get(id).callFrame;
    const name = `${functionName || '(anonymous)'} ${url.split('/').pop().replace(/-[^-]*$/, '')}`.trim();
    self.set(name, (self.get(name) ?? 0) + profile.timeDeltas[i] / 1000);
  });
  const idle = new Set(['(idle)', '(program)', '(root)']);
  return Object.fromEntries([...self].filter(([name]) => !idle.has(name)).sort((a, b) => b[1] - a[1]).slice(0, 25).map(([name, ms]) => [name, round(ms / frames)]));
}

// Goes to the campus and waits until `maps` of its maps are drawn.
export async function firstCampus(page, url, maps) {
  const requests = [];
  page.on('request', (request) => requests.push(new URL(request.url()).pathname));
  const begin = Date.now();
  await page.goto(url);
  await page.waitForFunction((n) => window.__scene?.drawn().filter(({ kind }) => kind === 'map').length >= n, maps, { timeout: 300_000 });
  return { first_campus_ms: Date.now() - begin, requests: requests.length, requested: [...requests] };
}

export const drawCalls = (page) => page.evaluate(() => window.__scene.stats().drawCalls);

// What the scripts take while the campus is dragged.
export const dragged = (page) => traced(page, () => pan(page));

// Opens the campus and drags it. `maps`: how many must be drawn until it counts as shown.
export async function measure(browser, url, maps, profiled = false) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const shown = await firstCampus(page, url, maps);
  await page.waitForTimeout(3000);
  const result = { ...shown, dragged: await dragged(page), draw_calls: await drawCalls(page), ...(profiled && { self_ms_per_frame: await profile(page) }) };
  await page.close();
  return result;
}
