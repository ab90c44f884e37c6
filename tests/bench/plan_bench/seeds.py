# SPDX-License-Identifier: Apache-2.0
"""Seeds of random buildings, as options give them."""


def seeds_of(text):
    """`7` is one seed, `1-10` are ten."""
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)
