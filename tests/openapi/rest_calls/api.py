# SPDX-License-Identifier: Apache-2.0
"""The server's API as service.api has it, but every call that has a rule goes over REST and is compared on its way."""
import collections
import http.client
import json
import time
import uuid

import grpc
from google.protobuf import json_format
from service import api

from . import rules

# Of RPCs to HTTP: google/rpc/code.proto.
STATUS = {"OK": 200, "INVALID_ARGUMENT": 400, "FAILED_PRECONDITION": 400, "OUT_OF_RANGE": 400, "NOT_FOUND": 404,
          "ALREADY_EXISTS": 409, "ABORTED": 409, "RESOURCE_EXHAUSTED": 429, "UNAVAILABLE": 503,
          "DEADLINE_EXCEEDED": 504}


class Difference(Exception):
    """REST says something else than gRPC."""


class RestApi(api.Api):
    """Calls through a gateway that has `proxy` between itself and the server."""

    def __init__(self, server, gateway, proxy, rules_by_name):
        super().__init__(server)
        self.gateway, self.proxy, self.rules = gateway, proxy, rules_by_name
        self.compared = collections.defaultdict(collections.Counter)  # of each RPC the HTTP statuses

    def call(self, method, requests, *, timeout, metadata=(), cancel_after=None, enough=64):
        message = method.request.FromString(requests[0])
        request = rules.request_of(self.rules.get(method.name, []), message)
        if request is None:
            return super().call(method, requests, timeout=timeout, metadata=metadata, cancel_after=cancel_after,
                                enough=enough)
        started = time.monotonic()
        identity = uuid.uuid4().hex
        status, body = self.ask(request, identity, timeout, enough)
        record = self.proxy.records.pop(identity, None)
        if record is None:
            raise Difference(f"{method.name}: {request.verb} {request.path} reached no RPC: {status} {body[:300]}")
        self.compare(method, message, request, status, body, record, enough)
        self.compared[method.name][status] += 1
        # A stream that was left is cancelled.
        code = record.code if status != 200 else grpc.StatusCode.OK
        return api.Answer(code, record.details, record.responses, time.monotonic() - started)

    def ask(self, request, identity, timeout, enough):
        """The status and the body; of a stream the first `enough` lines."""
        connection = http.client.HTTPConnection(self.gateway, timeout=timeout)
        try:
            headers = {"X-Request-Id": identity}
            if request.body:
                headers["Content-Type"] = "application/json"
            connection.request(request.verb, request.path, request.body or None, headers)
            response = connection.getresponse()
            if response.status == 200 and response.getheader("Content-Type") == "application/x-ndjson":
                lines = []
                while len(lines) < enough and (line := response.readline()):
                    lines.append(line)
                return 200, b"".join(lines)
            return response.status, response.read()
        finally:
            connection.close()

    def compare(self, method, message, request, status, body, record, enough):
        """Throws if the RPC did not get the message, or if the client did not get the RPC's answer."""
        what = f"{method.name} by {request.verb} {request.path}"
        if record.method != method.path:
            raise Difference(f"{what} called {record.method}")
        if [plain(method.request.FromString(sent)) for sent in record.requests] != [plain(message)]:
            raise Difference(f"{what}: the RPC got another request: {record.requests} for {message}")
        streamed = body.startswith(b'{"result":') or (status == 200 and not body)
        if not (streamed and enough <= len(record.responses)):
            record.ended.wait(60)
        if status != 200:
            self.compare_error(what, status, json.loads(body), record)
            return
        answers = [line["result"] for line in map(json.loads, body.splitlines())] if streamed else [json.loads(body)]
        got = [plain(json_format.ParseDict(one, method.response())) for one in answers]
        wanted = [plain(method.response.FromString(one)) for one in record.responses[:len(got) if streamed else None]]
        if got != wanted or (record.code != grpc.StatusCode.OK and not streamed):
            raise Difference(f"{what}: REST answers\n{got}\nand gRPC {record.code}\n{wanted}")

    @staticmethod
    def compare_error(what, status, body, record):
        body = body.get("error", body)  # of a stream
        wanted = (STATUS.get(record.code.name), record.code.value[0], record.details)
        if (status, body.get("code"), body.get("message")) != wanted:
            raise Difference(f"{what}: REST answers {status} {body}, gRPC {record.code} {record.details}")


def plain(message):
    """Equal for equal messages, also where they have NaN."""
    return message.SerializeToString(deterministic=True)
