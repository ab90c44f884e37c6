// SPDX-License-Identifier: Apache-2.0
// Robots that only say where they are. Poses come by gRPC alone: each robot has a session and a stream of its own.
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { credentials, loadPackageDefinition } from '@grpc/grpc-js';
import { loadSync } from '@grpc/proto-loader';

const protos = join(dirname(fileURLToPath(import.meta.url)), '../../proto');
const definition = loadSync('enfilade/v1/ingest_service.proto', { includeDirs: [protos, '/usr/include'], keepCase: true });
const { IngestService } = loadPackageDefinition(definition).enfilade.v1;

const timeOf = (ms) => ({ seconds: Math.floor(ms / 1000), nanos: (ms % 1000) * 1e6 });

export class Robots {
  refused = [];

  constructor(system, site) {
    this.system = system;
    this.site = site;
    this.client = new IngestService(`unix:${system.folder}/server.sock`, credentials.createInsecure());
    this.streams = new Map();
  }

  // Begins a session of the robot in `map` (an id); the robot is created if the site does not have it.
  async begin(robot, map) {
    const name = `sites/${this.site}/robots/${robot}`;
    await this.system.call(`sites/${this.site}/robots?robotId=${robot}`, { displayName: robot }).catch((error) => {
      if (!/ 409 /.test(error.message)) throw error;
    });
    const { session } = await this.system.call(`sites/${this.site}/sessions`, { robot: name, map: `sites/${this.site}/maps/${map}` });
    const stream = this.client.StreamRecords();
    await new Promise((resolve, reject) => {
      stream.once('error', reject);
      stream.on('data', (answer) => (answer.opened ? resolve() : this.refused.push(answer)));
      stream.write({ open: { session: session.name } });
    });
    stream.on('error', (error) => this.refused.push(error));
    this.streams.set(robot, stream);
    return name;
  }

  // `covariance`: 9 numbers, row by row.
  report(robot, map, pose, covariance = [0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.001]) {
    this.streams.get(robot).write({
      pose_report: { map: `sites/${this.site}/maps/${map}`, pose_map_robot: { pose, covariance }, time: timeOf(Date.now()) },
    });
  }

  close() {
    for (const stream of this.streams.values()) {
      stream.on('error', () => {}); // being cancelled is one
      stream.cancel();
    }
    this.client.close();
  }
}
