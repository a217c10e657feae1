"""What is loaded when, since every start of a command pays for it."""

import subprocess
import sys

HEAVY = ("numpy", "rosbags", "yaml", "difflib", "tempfile", "teleopctl.packages")


def loaded(code: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys\nprint(*sys.modules)"],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.split())


def test_names_of_types_need_nothing_heavy():
    modules = loaded("import teleopctl.interfaces.typenames")
    assert not modules.intersection(HEAVY)


def test_sending_a_known_message_reads_no_store_and_no_packages():
    code = (
        "from teleopctl.interfaces.store import get_message, type_hash\n"
        "from teleopctl.interfaces.cdr import serialize\n"
        "serialize(get_message('sensor_msgs/msg/JointState')())\n"
        "type_hash('rcl_interfaces/srv/SetParameters')\n"
    )
    loaded(code)  # leaves the table of the distribution in the cache
    modules = loaded(code)
    assert not modules.intersection({"rosbags.typesys", "yaml", "teleopctl.packages"})
