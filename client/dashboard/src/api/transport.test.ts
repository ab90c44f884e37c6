// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError, createClient } from '@connectrpc/connect';
import { expect, test } from 'vitest';
import { GraphService } from '../gen/enfilade/v1/graph_service_pb';
import { LinkPointService } from '../gen/enfilade/v1/link_point_service_pb';
import routes from '../gen/routes.json';
import { createRestTransport } from './transport';

const answering = (body: BodyInit, init?: ResponseInit) => createRestTransport(routes, async () => new Response(body, init));

// A body that comes in pieces, as from a socket.
const pieces = (...texts: string[]) =>
  new ReadableStream<Uint8Array>({
    start(controller) {
      for (const text of texts) controller.enqueue(new TextEncoder().encode(text));
      controller.close();
    },
  });

test('reads 64-bit integers exactly', async () => {
  const client = createClient(GraphService, answering('{"graph":{"graphVersion":"9007199254740993"}}'));
  const { graph } = await client.getGraph({ site: 'sites/s' });
  expect(graph?.graphVersion).toBe(9007199254740993n);
});

test('reads NaN and Infinity as numbers', async () => {
  const client = createClient(GraphService, answering('{"poses":[{"pose":{"x":"NaN","y":"-Infinity"}}]}'));
  const { poses } = await client.transformPoses({ sourceMap: 'sites/s/maps/m' });
  expect(poses[0]?.pose?.x).toBeNaN();
  expect(poses[0]?.pose?.y).toBe(-Infinity);
});

test('turns google.rpc.Status into an error with its code, message and request id', async () => {
  const transport = answering('{"code":5,"message":"sites/s does not exist"}', { status: 404, headers: { 'X-Request-Id': 'q7' } });
  const error = await createClient(GraphService, transport).getGraph({ site: 'sites/s' }).catch((e: unknown) => e as ConnectError);
  expect(error).toBeInstanceOf(ConnectError);
  expect(error).toMatchObject({ code: Code.NotFound, rawMessage: 'sites/s does not exist' });
  expect((error as ConnectError).metadata.get('x-request-id')).toBe('q7');
});

test('takes the HTTP status if the answer is not of the gateway', async () => {
  const transport = answering('<html>', { status: 502, statusText: 'Bad Gateway' });
  await expect(createClient(LinkPointService, transport).listLinkPoints({ parent: 'sites/s' })).rejects.toMatchObject({ code: Code.Unavailable });
});

test('says that the gateway cannot be reached', async () => {
  const transport = createRestTransport(routes, () => Promise.reject(new TypeError('fetch failed')));
  await expect(createClient(GraphService, transport).getGraph({ site: 'sites/s' })).rejects.toMatchObject({ code: Code.Unavailable });
});

test('reads a stream line by line, also where a piece ends within a line', async () => {
  const body = pieces('{"result":{"graphVersion":"1"}}\n{"result":{"gra', 'phVersion":"2"}}\n');
  const versions: bigint[] = [];
  for await (const part of createClient(GraphService, answering(body)).watchGlobalPoses({ parent: 'sites/s' })) versions.push(part.graphVersion);
  expect(versions).toEqual([1n, 2n]);
});

test('throws the error that ends a stream', async () => {
  const body = pieces('{"result":{"graphVersion":"1"}}\n', '{"error":{"code":14,"message":"shutting down"}}\n');
  const read = async () => {
    for await (const part of createClient(GraphService, answering(body)).watchGlobalPoses({ parent: 'sites/s' })) void part;
  };
  await expect(read()).rejects.toMatchObject({ code: Code.Unavailable, rawMessage: 'shutting down' });
});
