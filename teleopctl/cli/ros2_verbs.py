"""The verbs of ``ros2`` that are missing here, so that none is taken for a misspelt one."""

from __future__ import annotations

from collections.abc import Sequence

VERBS = {
    "security": (
        "create_enclave create_key create_keystore create_permission generate_artifacts "
        "generate_policy list_enclaves list_keys"
    ),
}


def exists(path: Sequence[str]) -> bool:
    """Return whether ``ros2`` has a noun or a verb."""
    verb, *rest = path
    return verb in VERBS and (not rest or rest[0] in VERBS[verb].split())
