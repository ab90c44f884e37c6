# SPDX-License-Identifier: Apache-2.0
"""Calls that survive a server that is killed: what is lost is sent again, what is refused is told."""
import threading
import time

import grpc
from google.protobuf.message import Message

# Nobody knows whether such a call was done.
LOST = (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED, grpc.StatusCode.DEADLINE_EXCEEDED)
CUT = ("Stream removed", "RST_STREAM", "Connection reset", "Socket closed")  # gRPC's own words for the same
REFUSALS = ("NOT_FOUND", "ALREADY_EXISTS", "FAILED_PRECONDITION", "ABORTED")
PATIENCE_S = 90  # with the server after a kill, and with a machine that is busy
CALL_S = 60


class Refused(Exception):
    """The server has answered that it does not do it."""

    def __init__(self, name, answer):
        super().__init__(f"{name}: {answer.code.name} {answer.details}")
        self.code, self.details = answer.code.name, answer.details
        # Two transactions that waited for one another: nothing is changed, and the caller may try again.
        self.is_deadlock = self.code == "ABORTED" and "40P01" in self.details


class Lost(Exception):
    """The answer did not arrive."""


class Fault(Exception):
    """What must never be."""


class Calls:
    """Of one server by their names."""

    def __init__(self, api):
        self.api = api
        self.up = threading.Event()
        self.up.set()
        self.publishing = threading.Event()  # someone has begun to

    def stream(self, name, requests, timeout=CALL_S):
        """All responses to requests, which are messages or dictionaries. Lost, Refused, or Fault: an error that none of
        these calls may have."""
        method = self.api.methods[name]
        messages = (one if isinstance(one, Message) else method.request(**one) for one in requests)
        answer = self.api.call(method, (message.SerializeToString() for message in messages), timeout=timeout,
                               enough=10_000)
        if answer.code == grpc.StatusCode.OK:
            return [method.response.FromString(response) for response in answer.responses]
        if answer.code in LOST or any(words in answer.details for words in CUT):
            raise Lost(f"{name}: {answer.code.name} {answer.details}")
        if answer.code.name in REFUSALS:
            raise Refused(name, answer)
        raise Fault(f"{name}: {answer.code.name} {answer.details}")

    def once(self, rpc, /, **request):
        return self.stream(rpc, [request])[0]

    def again(self, name, request_of, lost=None):
        """Streams what `request_of()` gives until an answer arrives. Appends to `lost` each time that none did."""
        give_up = time.monotonic() + PATIENCE_S
        while True:
            try:
                return self.stream(name, request_of())
            except Lost as error:
                if lost is not None:
                    lost.append(name)
                if time.monotonic() > give_up:
                    raise Fault(f"no answer in {PATIENCE_S} s: {error}") from error
                time.sleep(0.02)
                self.up.wait()

    def sure(self, rpc, lost=None, /, **request):
        """The answer, however often it must be asked for."""
        return self.again(rpc, lambda: [request], lost)[0]

    def pages(self, rpc, field, /, **request):
        """All items of a list."""
        items, token = [], ""
        while True:
            page = self.sure(rpc, None, page_size=1000, page_token=token, **request)
            items += getattr(page, field)
            token = page.next_page_token
            if not token:
                return items
