// SPDX-License-Identifier: Apache-2.0
// Which HTTP request is a call: the rules of google.api.http, as far as proto/gateway.yaml uses them.
import type { JsonObject, JsonValue } from '@bufbuild/protobuf';

export interface Binding {
  verb: string;
  path: string;
  body?: string;
}

export interface HttpCall {
  verb: string;
  url: string;
  // JSON; absent if the verb takes none.
  body?: string;
}

const camelCase = (name: string) => name.replace(/_([a-z0-9])/g, (_, letter: string) => letter.toUpperCase());

// "{site.name=sites/*}" names the field site.name.
const variable = /\{([\w.]+)(?:=([^}]*))?\}/g;

function take(message: JsonObject, path: string[]): JsonValue | undefined {
  const [head, ...rest] = path;
  if (head === undefined) return undefined;
  const value = message[head];
  if (rest.length === 0) {
    delete message[head];
    return value;
  }
  return value !== null && typeof value === 'object' && !Array.isArray(value) ? take(value, rest) : undefined;
}

// The pattern of a name, for example sites/*/maps/*.
function fits(name: string, pattern: string) {
  const parts = name.split('/');
  const wanted = pattern.split('/');
  return parts.length === wanted.length && wanted.every((part, i) => (part === '*' ? parts[i] !== '' : part === parts[i]));
}

function addQuery(query: URLSearchParams, prefix: string, value: JsonValue | undefined) {
  if (value === undefined || value === null) return;
  if (Array.isArray(value)) {
    for (const item of value) addQuery(query, prefix, item);
  } else if (typeof value === 'object') {
    for (const [key, item] of Object.entries(value)) addQuery(query, prefix === '' ? key : `${prefix}.${key}`, item);
  } else {
    query.append(prefix, String(value));
  }
}

function bind(binding: Binding, source: JsonObject): HttpCall | undefined {
  const message = structuredClone(source);
  let complete = true;
  const path = binding.path.replace(variable, (_, field: string, pattern: string | undefined) => {
    const name = take(message, field.split('.').map(camelCase));
    if (typeof name !== 'string' || !fits(name, pattern ?? '*')) complete = false;
    return String(name).split('/').map(encodeURIComponent).join('/');
  });
  if (!complete) return undefined;
  if (binding.body === '*') return { verb: binding.verb, url: path, body: JSON.stringify(message) };
  let body: string | undefined;
  if (binding.body !== undefined) body = JSON.stringify(take(message, [camelCase(binding.body)]) ?? {});
  const query = new URLSearchParams();
  addQuery(query, '', message);
  const search = query.toString();
  return { verb: binding.verb, url: search === '' ? path : `${path}?${search}`, ...(body !== undefined && { body }) };
}

// The first binding whose path the message fills. Throws if there is none: then a name in the message is wrong.
export function callOf(method: string, bindings: readonly Binding[] | undefined, message: JsonObject): HttpCall {
  for (const binding of bindings ?? []) {
    const call = bind(binding, message);
    if (call) return call;
  }
  throw new Error(`${method} has no address for ${JSON.stringify(message)}`);
}
