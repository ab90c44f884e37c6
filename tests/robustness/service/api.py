# SPDX-License-Identifier: Apache-2.0
"""The server's API, learnt from its reflection service, and calls of any kind with any bytes."""
import dataclasses
import threading
import time

import grpc
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

REFLECTION = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"
STANDARD_SERVICES = ("grpc.health.", "grpc.reflection.")


def reflection_response():
    """The class of ServerReflectionResponse: the fields used here of grpc/reflection/v1alpha/reflection.proto."""
    file = descriptor_pb2.FileDescriptorProto(name="reflection.proto", package="r", syntax="proto3")

    def message(name, *fields):
        added = file.message_type.add(name=name)
        for field, number, repeated, kind in fields:
            one = added.field.add(name=field, number=number, label=3 if repeated else 1,
                                  type={"string": 9, "bytes": 12}.get(kind, 11))
            if one.type == 11:
                one.type_name = f".r.{kind}"

    message("Service", ("name", 1, False, "string"))
    message("Services", ("service", 1, True, "Service"))
    message("Files", ("file", 1, True, "bytes"))
    message("Response", ("files", 4, False, "Files"), ("services", 6, False, "Services"))
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.MessageFactory(pool).GetPrototype(pool.FindMessageTypeByName("r.Response"))


@dataclasses.dataclass
class Method:
    """One RPC."""
    name: str  # MapService.GetMap
    path: str  # /enfilade.v1.MapService/GetMap
    request: type
    response: type
    client_streaming: bool


@dataclasses.dataclass
class Answer:
    """How a call ended."""
    code: grpc.StatusCode
    details: str
    responses: list  # bytes
    seconds: float


class Api:
    """All RPCs of a server but those of gRPC's standard services."""

    def __init__(self, address):
        self.address = address
        self.channel = None
        self.connect()
        self.methods = {}
        self._learn()

    def connect(self):
        """Also after the server was killed: a new channel does not wait as long as an old one until it tries again."""
        limits = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]
        channel = grpc.insecure_channel(self.address, options=limits + [("grpc.use_local_subchannel_pool", 1)])
        grpc.channel_ready_future(channel).result(timeout=30)
        self.channel = channel

    def _learn(self):
        response = reflection_response()
        stub = self.channel.stream_stream(REFLECTION, None, response.FromString)

        def ask(field, text):
            return next(stub(iter([bytes([field << 3 | 2, len(text)]) + text.encode()]), timeout=30))

        pool = descriptor_pool.DescriptorPool()
        services = [s.name for s in ask(7, "*").services.service if not s.name.startswith(STANDARD_SERVICES)]
        known = {}
        for service in services:
            for data in ask(4, service).files.file:
                file = descriptor_pb2.FileDescriptorProto.FromString(data)
                known[file.name] = file
        added = set()

        def add(name):
            if name in added:
                return
            added.add(name)
            for dependency in known[name].dependency:
                add(dependency)
            pool.Add(known[name])

        for name in known:
            add(name)
        factory = message_factory.MessageFactory(pool)
        for service in services:
            for method in pool.FindServiceByName(service).methods:
                proto = descriptor_pb2.MethodDescriptorProto()
                method.CopyToProto(proto)
                name = f"{service.rsplit('.', 1)[1]}.{method.name}"
                self.methods[name] = Method(name, f"/{service}/{method.name}", factory.GetPrototype(method.input_type),
                                            factory.GetPrototype(method.output_type), proto.client_streaming)

    def call(self, method, requests, *, timeout, metadata=(), cancel_after=None, enough=64):
        """Sends the requests (bytes) and waits for the end, or for `enough` responses; then it cancels.

        Every kind of RPC is called as a stream, which is the same on the wire: so a unary one may get none or several.
        """
        started = time.monotonic()
        responses = []
        call = self.channel.stream_stream(method.path)(iter(requests), timeout=timeout, metadata=metadata)
        timer = threading.Timer(cancel_after, call.cancel) if cancel_after is not None else None
        if timer:
            timer.start()
        try:
            for response in call:
                responses.append(response)
                if len(responses) >= enough:
                    call.cancel()
                    return Answer(grpc.StatusCode.OK, "enough", responses, time.monotonic() - started)
        except grpc.RpcError:
            pass
        finally:
            if timer:
                timer.cancel()
        return Answer(call.code(), call.details() or "", responses, time.monotonic() - started)
