# SPDX-License-Identifier: Apache-2.0
"""Between the gateway and the server: passes every call on, and keeps what went each way."""
import dataclasses
import threading
from concurrent import futures

import grpc

ANY_SIZE = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]
# What gRPC itself sends along.
OF_THE_CONNECTION = ("grpc-", "user-agent", "content-type", "te")
DAY_S = 86_400
STATUS_DETAILS = "grpc-status-details-bin"


@dataclasses.dataclass
class Record:
    """A call as it went over the wire."""
    method: str
    requests: list = dataclasses.field(default_factory=list)  # bytes
    responses: list = dataclasses.field(default_factory=list)
    code: grpc.StatusCode = grpc.StatusCode.OK
    details: str = ""
    ended: threading.Event = dataclasses.field(default_factory=threading.Event)


class Proxy(grpc.GenericRpcHandler):
    """Listens at a Unix socket. Every RPC is passed on as a stream, which is the same on the wire."""

    def __init__(self, address, server):
        self.records = {}  # by the call's x-request-id
        self.channel = grpc.insecure_channel(server, options=ANY_SIZE)
        self.server = grpc.server(futures.ThreadPoolExecutor(16), handlers=[self], options=ANY_SIZE)
        self.server.add_insecure_port(address)
        self.server.start()

    def service(self, handler_call_details):
        path = handler_call_details.method
        return grpc.stream_stream_rpc_method_handler(lambda requests, context: self.forward(path, requests, context))

    def forward(self, path, requests, context):
        metadata = dict(context.invocation_metadata())
        record = self.records[metadata.get("x-request-id", "")] = Record(path)

        def kept():
            for request in requests:
                record.requests.append(request)
                yield request

        passed = [(key, value) for key, value in metadata.items() if not key.startswith(OF_THE_CONNECTION)]
        left = context.time_remaining()  # without a deadline: until far in the future
        call = self.channel.stream_stream(path)(kept(), metadata=passed, timeout=left if left and left < DAY_S else None)
        context.add_callback(call.cancel)
        try:
            for response in call:
                record.responses.append(response)
                yield response
        except grpc.RpcError:
            pass
        record.code, record.details = call.code(), call.details() or ""
        record.ended.set()
        context.set_trailing_metadata([(key, value) for key, value in call.trailing_metadata()
                                       if key == STATUS_DETAILS or not key.startswith(OF_THE_CONNECTION)])
        context.set_code(record.code)
        context.set_details(record.details)

    def stop(self):
        self.server.stop(None).wait()
        self.channel.close()
