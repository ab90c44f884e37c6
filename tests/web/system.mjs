// SPDX-License-Identifier: Apache-2.0
// A database, a server and a gateway of the tests' own, and robots of the simulator. Everything is stopped by its process id.
import { execFileSync, spawn } from 'node:child_process';
import { chmodSync, mkdtempSync, openSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const programs = process.env.ENFILADE_BIN;

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Waits until `holds` returns something true, and returns that.
export async function until(what, holds, seconds = 120) {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await pause(100)) {
    const result = await holds();
    if (result) return result;
  }
  throw new Error(`${what}: not within ${seconds} s`);
}

const stopped = (child) => new Promise((resolve) => {
  if (child.exitCode !== null || child.signalCode !== null) return resolve();
  child.once('exit', resolve);
});

export class System {
  folder = mkdtempSync(join(tmpdir(), 'enfilade-web-'));
  server;
  gateway;
  url;

  async start() {
    chmodSync(this.folder, 0o755); // the database's owner enters it
    const database = execFileSync(join(root, 'deploy/database/cluster'), ['start', join(this.folder, 'database')]);
    this.database = database.toString().trim();
    execFileSync(join(root, 'deploy/database/migrate'), ['up', this.database], { stdio: 'pipe' });
    this.startServer();
    await this.startGateway();
    await this.ready();
  }

  startServer() {
    this.server = this.#run('enfilade-server', 'server.log',
      ['--set', `listen.address=unix:${this.folder}/server.sock`, '--set', 'metrics.address=',
        '--set', `transfers.cache_directory=${this.folder}`],
      { ENFILADE_SERVER_DATABASE_URL: this.database });
  }

  serverRuns() {
    return this.server.exitCode === null && this.server.signalCode === null;
  }

  // Again at the address that it had.
  async startGateway() {
    this.gateway = this.#run('enfilade-gateway', 'gateway.log',
      ['--listen', this.url ? new URL(this.url).host : '127.0.0.1:0', '--metrics', '', '--server', `unix:${this.folder}/server.sock`,
        '--calls-per-second', '0', '--tiles-per-second', '0']);
    const line = await until('the gateway listens', () => /.*"msg":"listening".*/.exec(this.log('gateway.log'))?.[0]);
    this.url = `http://${JSON.parse(line).address}`;
  }

  ready() {
    return until('the server is ready', async () => (await fetch(`${this.url}/readyz`).catch(() => undefined))?.ok);
  }

  log(name) {
    return readFileSync(join(this.folder, name), 'utf8');
  }

  async kill(name) {
    this[name].kill('SIGKILL');
    await stopped(this[name]);
  }

  // Runs the command `enfilade` at a site; returns what it prints.
  enfilade(site, ...args) {
    return execFileSync(join(programs, 'enfilade'), args, { env: this.#environmentOf(site), stdio: ['ignore', 'pipe', 'pipe'] }).toString();
  }

  // The same beside what else is done; the promise ends with it. `log`: where it writes to.
  async aside(site, log, ...args) {
    const child = this.#run('enfilade', log, args, this.#environmentOf(site));
    await stopped(child);
    if (child.exitCode !== 0) throw new Error(`enfilade ${args.join(' ')} failed:\n${this.log(log).slice(-2000)}`);
  }

  // Drives a robot through a simulated campus; the promise ends with it.
  drive(site, robot, ...args) {
    return this.aside(site, `${site}-${robot}.log`, 'robot', '--robot', robot, '--spool', join(this.folder, `${site}-${robot}.spool`), '--wait', ...args);
  }

  // Calls the API over REST.
  async call(path, body) {
    // While `enfilade` ran nothing was noticed, not even that the gateway has closed an idle connection.
    await new Promise(setImmediate);
    const init = body === undefined ? {} : { method: 'POST', body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' } };
    const answer = await fetch(`${this.url}/v1/${path}`, init);
    if (!answer.ok) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
    return answer.json();
  }

  async stop() {
    for (const child of [this.gateway, this.server]) {
      if (!child) continue;
      child.kill('SIGKILL');
      await stopped(child);
    }
    execFileSync(join(root, 'deploy/database/cluster'), ['stop', join(this.folder, 'database')], { stdio: 'pipe' });
    rmSync(this.folder, { recursive: true, force: true });
  }

  #environmentOf(site) {
    return { ...process.env, ENFILADE_SERVER: `unix:${this.folder}/server.sock`, ENFILADE_SITE: site };
  }

  #run(program, log, args, environment = {}) {
    const file = openSync(join(this.folder, log), 'a');
    return spawn(join(programs, program), args, { env: { ...process.env, ...environment }, stdio: ['ignore', file, file] });
  }
}
