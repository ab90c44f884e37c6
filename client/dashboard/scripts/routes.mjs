// SPDX-License-Identifier: Apache-2.0
// usage: routes.mjs GATEWAY_YAML ROUTES_JSON
// Turns the gateway's rules into what src/api/routes.ts reads: RPC -> [{verb, path, body}].
import { readFileSync, writeFileSync } from 'node:fs';
import { parse } from 'yaml';

const [rules, target] = process.argv.slice(2);
const routes = {};

function bindingOf(rule) {
  const verb = ['get', 'post', 'put', 'patch', 'delete'].find((name) => rule[name] !== undefined);
  if (verb === undefined) throw new Error(`no verb: ${JSON.stringify(rule)}`);
  return { verb: verb.toUpperCase(), path: rule[verb], ...(rule.body && { body: rule.body }) };
}

for (const rule of parse(readFileSync(rules, 'utf8')).http.rules) {
  routes[rule.selector] = [bindingOf(rule), ...(rule.additional_bindings ?? []).map(bindingOf)];
}
writeFileSync(target, JSON.stringify(routes, null, 1) + '\n');
