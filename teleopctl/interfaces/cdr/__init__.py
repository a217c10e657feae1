"""Messages as bytes: plain CDR in the encapsulation that ROS 2 uses (OMG DDS-XTypes, XCDR1).

`layout` has the rules of the standard. `writing` and `reading` generate the source of a function
from a definition by those rules, `codec` compiles and caches the functions, and `serialization`
calls them. `prepared_message`, not imported here, changes numbers in serialized messages.
"""

from teleopctl.interfaces.cdr.serialization import (
    as_numpy,
    check_readable,
    class_within,
    deserialize,
    serialize,
)

__all__ = ["as_numpy", "check_readable", "class_within", "deserialize", "serialize"]
