# SPDX-License-Identifier: Apache-2.0
"""The HTTP request of an RPC, as proto/gateway.yaml says (google.api.HttpRule), made anew: not by the gateway's own code."""
import dataclasses
import json
import re
from urllib.parse import quote, urlencode

import yaml
from google.protobuf import json_format

VERBS = ("get", "post", "put", "patch", "delete")
VARIABLE = re.compile(r"\{([a-z_.]+)(?:=([^}]*))?\}")


@dataclasses.dataclass
class Request:
    """Of HTTP."""
    verb: str
    path: str  # with its query
    body: bytes  # empty: none


def rules_of(file):
    """The rules of each RPC ("MapService.GetMap"): (verb, path, body) each, the main one first."""
    rules = {}
    for rule in yaml.safe_load(file.read_text())["http"]["rules"]:
        bindings = [rule, *rule.get("additional_bindings", [])]
        name = rule["selector"].rsplit(".", 2)
        rules[".".join(name[1:])] = [(verb, binding[verb], binding.get("body", ""))
                                     for binding in bindings for verb in VERBS if verb in binding]
    return rules


def request_of(rules, message):
    """By the first rule whose path has room for the names in the message; None if there is none. A body is never unset:
    what the message lacks there is added to it, empty."""
    for verb, template, body in rules:
        fields = json_format.MessageToDict(message)
        path = fill(template, message, fields)
        if path is None:
            continue
        content = b""
        if body == "*":
            content, fields = json.dumps(fields).encode(), {}
        elif body:
            getattr(message, body).SetInParent()
            resource = fields.pop(json_name(body), {})
            content = json.dumps(resource).encode()
            if verb == "patch" and not resource and "update_mask" in message.DESCRIPTOR.fields_by_name:
                message.update_mask.SetInParent()  # made of the body's fields, of which there are none
        query = urlencode(list(flat(fields)))
        return Request(verb.upper(), path + ("?" + query if query else ""), content)
    return None


def json_name(name):
    return re.sub("_(.)", lambda match: match[1].upper(), name)


def fill(template, message, fields):
    """The path; what it says is taken out of the fields. None if a variable is not as the template wants it."""
    path, end = "", 0
    for match in VARIABLE.finditer(template):
        value = message
        for name in match[1].split("."):
            value = getattr(value, name)
        pattern = (match[2] or "*").replace("*", "[^/]+")
        if not re.fullmatch(pattern, str(value)):
            return None
        remove(fields, [json_name(name) for name in match[1].split(".")])
        path += template[end:match.start()] + quote(str(value))
        end = match.end()
    return path + template[end:]


def remove(fields, names):
    for name in names[:-1]:
        fields = fields[name]
    fields.pop(names[-1], None)


def flat(fields, prefix=""):
    """As parameters of a query: names of nested fields are joined by dots, lists are repeated."""
    for name, value in fields.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        else:
            for one in value if isinstance(value, list) else [value]:
                yield prefix + name, json.dumps(one) if isinstance(one, bool) else str(one)
