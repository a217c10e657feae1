"""Time, durations, timers, rates; ends by itself."""

import threading

import rclpy
from builtin_interfaces.msg import Time as TimeMsg
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.time import Time


def main():
    rclpy.init()
    node = rclpy.create_node("timekeeper")
    now = node.get_clock().now()
    stamp = now.to_msg()
    assert isinstance(stamp, TimeMsg)
    assert Time.from_msg(stamp) == now
    assert (now + Duration(seconds=1.5)) - now == Duration(nanoseconds=1_500_000_000)
    assert now.seconds_nanoseconds()[0] == stamp.sec
    assert Clock().clock_type == ClockType.SYSTEM_TIME
    assert Clock(clock_type=ClockType.STEADY_TIME).now().nanoseconds > 0
    assert rclpy.time.Time().nanoseconds == 0

    calls = []
    timer = node.create_timer(0.001, lambda: calls.append("timer"))
    while not calls:
        rclpy.spin_once(node, timeout_sec=10.0)
    timer.cancel()
    assert timer.is_canceled()
    count = len(calls)
    rclpy.spin_once(node, timeout_sec=0)
    assert len(calls) == count
    timer.reset()
    while len(calls) == count:
        rclpy.spin_once(node)
    assert node.destroy_timer(timer)

    guard = node.create_guard_condition(lambda: calls.append("guard"))
    threading.Thread(target=guard.trigger).start()
    rclpy.spin_once(node, timeout_sec=10.0)
    assert calls[-1] == "guard"

    executor = SingleThreadedExecutor()
    executor.add_node(node)
    assert node.executor is executor
    spinner = threading.Thread(target=executor.spin, daemon=True)
    spinner.start()
    rate = node.create_rate(200)
    for _ in range(3):
        rate.sleep()
    assert node.get_clock().sleep_for(Duration(seconds=0.001))
    rclpy.shutdown()
    spinner.join()
    node.destroy_node()
    print("done")


if __name__ == "__main__":
    main()
