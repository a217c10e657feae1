"""ROS 2's security variables, read as rcl reads them (rcl/security.c).

Only ``ROS_SECURITY_ENABLE=true`` enables security, and only ``ROS_SECURITY_STRATEGY=Enforce``
forbids to run without keys; both values are case-sensitive. Keys (``ROS_SECURITY_KEYSTORE``,
``ROS_SECURITY_ENCLAVE_OVERRIDE``) are not supported yet, so that no session is secure.
"""

from __future__ import annotations

import os

from teleopctl.errors import UnsupportedError

_ENABLE = "ROS_SECURITY_ENABLE"
_STRATEGY = "ROS_SECURITY_STRATEGY"
_ON = "true"
_ENFORCE = "Enforce"
# Values probably meant to enable security; except for ``true`` itself, rcl treats them as off.
_MEANT_AS_ON = {"true", "1", "on", "yes"}

_HINT = (
    f"Unset {_ENABLE}, or set {_STRATEGY}=Permissive, to communicate without encryption and "
    "access control."
)

_warned: set[str] = set()


def check_security() -> None:
    """Raise if ROS security is enforced, which is unsupported; warn if it is permissive.

    Raises:
        UnsupportedError: Security is enforced.
    """
    enable = os.environ.get(_ENABLE, "")
    if enable == _ON:
        strategy = os.environ.get(_STRATEGY, "")
        if strategy == _ENFORCE:
            raise UnsupportedError(
                f"{_STRATEGY}={_ENFORCE} forbids to communicate without keys, and teleopctl cannot "
                "use keys yet.",
                hint=_HINT,
            )
        _warn_once(
            f"{_ENABLE} is {_ON}, but teleopctl cannot use keys yet: nothing is encrypted or "
            f"authenticated. {_STRATEGY} is {strategy!r}; only {_ENFORCE!r} would refuse this."
        )
    elif enable.strip().lower() in _MEANT_AS_ON:
        _warn_once(
            f"{_ENABLE} is {enable!r}, which ROS 2 treats as off: only {_ON!r} turns security on. "
            "Nothing is encrypted or authenticated."
        )


def _warn_once(text: str) -> None:
    if text not in _warned:
        import logging

        _warned.add(text)
        logging.getLogger(__name__).warning(text)
