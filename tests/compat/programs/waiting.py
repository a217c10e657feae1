"""Program that blocks forever in the state that its argument names."""

import contextlib
import sys
import threading
import time

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor


def spin_quietly(node):
    with contextlib.suppress(ExternalShutdownException):
        rclpy.spin(node)


def work_while_ok():
    while rclpy.ok():
        time.sleep(0.05)


def main():
    rclpy.init()
    node = rclpy.create_node("waiting")
    state = sys.argv[1]
    if state not in ("callback", "pool", "service"):
        print("waiting", flush=True)
    if state == "spin":
        rclpy.spin(node)
    elif state == "spin_once":
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=10.0)
    elif state == "service":
        client = node.create_client(AddTwoInts, "nobody")
        print("waiting", flush=True)
        client.wait_for_service()
    elif state == "callback":
        node.create_timer(0.001, lambda: (print("waiting", flush=True), time.sleep(0.2)))
        rclpy.spin(node)
    elif state == "rate":
        threading.Thread(target=spin_quietly, args=(node,), daemon=True).start()
        node.create_rate(0.01).sleep()
    elif state == "thread":
        # Not a daemon thread: the program does not end before the thread.
        threading.Thread(target=spin_quietly, args=(node,)).start()
        work_while_ok()
    elif state == "pool":
        executor = MultiThreadedExecutor(2)
        executor.add_node(node)
        executor.create_task(lambda: (print("waiting", flush=True), work_while_ok()))
        executor.spin()
    elif state == "sleep":
        while rclpy.ok():
            time.sleep(0.05)


if __name__ == "__main__":
    main()
