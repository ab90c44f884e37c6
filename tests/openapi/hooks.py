# SPDX-License-Identifier: Apache-2.0
"""Half of the calls name what is there: schemathesis by itself makes up names that no site has."""
import json
import os

import schemathesis
from hypothesis import strategies

NAMES = json.loads(os.environ["ENFILADE_NAMES"])  # of each path parameter


@schemathesis.hook
def flatmap_path_parameters(context, path_parameters):
    """What a call deletes is of a site of its own, so that the others have something to call."""
    if not path_parameters:
        return strategies.just(path_parameters)
    known = {**NAMES, "site": ["doomed"]} if context.operation.method.upper() == "DELETE" else NAMES
    chosen = {name: strategies.sampled_from(known[name]) if name in known else strategies.just(value)
              for name, value in path_parameters.items()}
    return strategies.one_of(strategies.fixed_dictionaries(chosen), strategies.just(path_parameters))
