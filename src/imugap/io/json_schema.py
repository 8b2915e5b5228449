"""Import the JSON-Schema validator without its checks of text formats, which no schema here uses.

Where ``rfc3987_syntax`` is installed (Jupyter brings it along), jsonschema imports it for the format "iri", and it
builds 38 grammars on import: two seconds in every process, against 0.2 s for all else.
"""

import sys

SLOW = "rfc3987_syntax"

sys.modules.setdefault(SLOW, None)  # its import fails, which jsonschema takes for a package that is not installed

from jsonschema import Draft202012Validator, ValidationError, validators  # noqa: E402

if sys.modules[SLOW] is None:
    del sys.modules[SLOW]

__all__ = ["Draft202012Validator", "ValidationError", "validators"]
