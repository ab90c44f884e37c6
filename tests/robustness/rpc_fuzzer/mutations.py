# SPDX-License-Identifier: Apache-2.0
"""Malformed and extreme requests, made from valid ones."""
import math

from google.protobuf.descriptor import FieldDescriptor as Field

INTEGERS = [0, 1, -1, 2, 1000, 1001, 2**31 - 1, -2**31, 2**31, 2**32 - 1, 2**63 - 1, -2**63, 10**12, 253402300800]
NUMBERS = [0.0, -0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 1e-300, 1e9, math.pi, 2.0**63]
TEXTS = ["", "-", "sites/", "sites/-", "sites/x/maps/", "../../etc/passwd", "'; DROP TABLE sites; --", "%s%n", "\0",
         "a\0b", "\u202e\U0001f600", "A" * 64, "a" * 63, "name,name", "0" * 1000, "sites/" + "a/" * 500, "*", "NaN",
         "2147483648", "\n" * 100]
REPEATS = [2, 3, 17, 100, 1001, 10_001]
INTEGER_RANGES = {Field.CPPTYPE_INT32: (-2**31, 2**31 - 1), Field.CPPTYPE_ENUM: (-2**31, 2**31 - 1),
                  Field.CPPTYPE_INT64: (-2**63, 2**63 - 1), Field.CPPTYPE_UINT32: (0, 2**32 - 1),
                  Field.CPPTYPE_UINT64: (0, 2**64 - 1)}


def scalar(field, names, rng):
    """An extreme value of the field's type. `names`: of resources that exist or did."""
    kind = field.cpp_type
    if kind == Field.CPPTYPE_BOOL:
        return rng.random() < 0.5
    if kind in (Field.CPPTYPE_DOUBLE, Field.CPPTYPE_FLOAT):
        return rng.choice(NUMBERS) if rng.random() < 0.7 else rng.uniform(-100, 100)
    if kind in INTEGER_RANGES:
        low, high = INTEGER_RANGES[kind]
        value = rng.randrange(-2, 9) if rng.random() < 0.5 else rng.choice(INTEGERS)
        return min(max(value, low), high)
    if field.type == Field.TYPE_BYTES:
        return rng.randbytes(rng.choice([0, 1, 31, 32, 33, 1000, 100_000]))
    if names and rng.random() < 0.5:
        name = rng.choice(names)
        return name if rng.random() < 0.8 else name[:rng.randrange(len(name) + 1)]
    return "é" * 200_000 if rng.random() < 0.02 else rng.choice(TEXTS)


def places(message, depth=0):
    """(message, field) of all fields of a message and of those within it, set or not."""
    for field in message.DESCRIPTOR.fields:
        yield message, field
        if field.cpp_type != Field.CPPTYPE_MESSAGE or depth > 6:
            continue
        if field.label == Field.LABEL_REPEATED:
            for element in list(getattr(message, field.name))[:3]:
                yield from places(element, depth + 1)
        elif message.HasField(field.name):
            yield from places(getattr(message, field.name), depth + 1)


def change(message, field, names, rng):
    """Changes one field."""
    if rng.random() < 0.1:
        message.ClearField(field.name)
    elif field.label == Field.LABEL_REPEATED:
        change_repeated(getattr(message, field.name), field, names, rng)
    elif field.cpp_type == Field.CPPTYPE_MESSAGE:
        inner = getattr(message, field.name)
        inner.SetInParent()
        for _ in range(rng.randrange(3)):
            if inner.DESCRIPTOR.fields:
                change(inner, rng.choice(inner.DESCRIPTOR.fields), names, rng)
    else:
        setattr(message, field.name, scalar(field, names, rng))


def change_repeated(values, field, names, rng):
    is_message = field.cpp_type == Field.CPPTYPE_MESSAGE
    if not values or rng.random() < 0.3:
        if is_message:
            change_any(values.add(), names, rng)
        else:
            values.append(scalar(field, names, rng))
    elif rng.random() < 0.3:
        del values[rng.randrange(len(values))]
    elif rng.random() < 0.4:
        copied = values[rng.randrange(len(values))]
        size = copied.ByteSize() if is_message else 16
        times = rng.choice(REPEATS)
        values.extend([copied] * (times if times * size < 2_000_000 else 2))
    elif is_message:
        change_any(rng.choice(values), names, rng)
    else:
        values[rng.randrange(len(values))] = scalar(field, names, rng)


def change_any(message, names, rng):
    found = list(places(message))
    if found:
        change(*rng.choice(found), names, rng)


def change_bytes(data, rng):
    """Bits, bytes, stretches: mostly no valid message any more."""
    data = bytearray(data)
    for _ in range(rng.randrange(1, 6)):
        at = rng.randrange(len(data) + 1)
        choice = rng.randrange(4)
        if choice == 0 and at < len(data):
            data[at] ^= 1 << rng.randrange(8)
        elif choice == 1:
            data[at:at + rng.randrange(8)] = rng.randbytes(rng.randrange(8))
        elif choice == 2:
            del data[at:at + rng.randrange(64)]
        else:
            data[at:at] = data[at:at + 64]
    return bytes(data)


def requests_of(messages, names, rng):
    """A malformed or extreme sequence of requests, as bytes, made from a valid one, and what was done."""
    messages = [type(m).FromString(m.SerializeToString()) for m in messages]
    what = rng.choices(["valid", "fields", "order", "bytes", "noise"], [10, 65, 7, 15, 3])[0]
    if what == "fields":
        for _ in range(rng.randrange(1, 5)):
            change_any(rng.choice(messages), names, rng)
    data = [m.SerializeToString() for m in messages]
    if what == "order":
        choice = rng.randrange(4)
        if choice == 0:
            rng.shuffle(data)
        elif choice == 1:
            del data[rng.randrange(len(data))]
        else:
            data.insert(rng.randrange(len(data) + 1), rng.choice(data))
    elif what == "bytes":
        at = rng.randrange(len(data))
        data[at] = change_bytes(data[at], rng)
    elif what == "noise":
        data = [rng.randbytes(rng.choice([0, 1, 10, 1000, 50_000])) for _ in range(rng.randrange(3))]
    return data, what
