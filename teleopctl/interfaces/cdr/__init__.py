"""Messages as bytes: plain CDR in the encapsulation that ROS 2 uses (OMG DDS-XTypes, XCDR1).

`layout` has the rules of the standard, `writing` and `reading` turn a definition into the source of
a function by those rules, `codec` compiles and keeps the functions, `serialization` uses them.
`prepared`, not imported here, writes numbers into what was serialised before.
`prepared`, not imported here, writes numbers into what was serialised before.
"""

from teleopctl.interfaces.cdr.serialization import (
    as_numpy,
    check_readable,
    class_within,
    deserialize,
    serialize,
)

__all__ = ["as_numpy", "check_readable", "class_within", "deserialize", "serialize"]
