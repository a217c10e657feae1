"""A process that meets large messages keeps memory for the next ones."""

import mmap
import platform
import subprocess
import sys

import pytest

from teleopctl.interfaces import get_message

# Prints how many pages a block of 4 MB costs that is made and dropped again and again.
FAULTS = """
import resource
def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(20):
        bytes(bytearray(4_000_000))
    return (resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before) / 20
from teleopctl.interfaces import get_message
from teleopctl.node import Node, init
init(args=[])
node = Node("one")
Image = get_message("sensor_msgs/msg/Image")
"""
SENDS = """
node.create_publisher(Image, "image", 1).publish(Image(data=bytes(1_000_000)))
"""
HEARS = """
from teleopctl.node import spin_once
received = []
node.create_subscription(Image, "image", received.append, 1)
print("ready", flush=True)
while not received:
    spin_once(node)
"""
END = """
faults()
print(int(faults()))
"""
A_BLOCK_ANEW = 4_000_000 // mmap.PAGESIZE


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="others keep it by themselves")
def test_who_has_sent_an_image_copies_the_next_one_into_memory_that_it_has(ros):
    done = subprocess.run(
        [sys.executable, "-c", FAULTS + SENDS + END],
        env=ros.env,
        capture_output=True,
        text=True,
        check=True,
    )
    assert int(done.stdout) < A_BLOCK_ANEW / 10


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="others keep it by themselves")
def test_so_does_who_has_heard_one(ros):
    hearing = ros.spawn_command([sys.executable, "-c", FAULTS + HEARS + END])
    hearing.wait_for_line("ready")
    image = get_message("sensor_msgs/msg/Image")
    publisher = ros.node.create_publisher(image, "/image", 1)
    assert ros.node.wait_for_subscribers("/image", 1, 10)
    publisher.publish(image(data=bytes(1_000_000)))
    assert hearing.wait() == 0, hearing.stderr
    assert int(hearing.stdout.splitlines()[-1]) < A_BLOCK_ANEW / 10


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="others keep it by themselves")
def test_the_users_own_settings_stay(ros):
    done = subprocess.run(
        [sys.executable, "-c", FAULTS + END + SENDS + END],
        env={**ros.env, "MALLOC_MMAP_THRESHOLD_": "131072"},
        capture_output=True,
        text=True,
        check=True,
    )
    before, after = map(int, done.stdout.split())
    assert after == pytest.approx(before, rel=0.1, abs=10)
