"""Service and client in the ways that tutorials show; ends by itself."""

import threading

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class AddServer(Node):
    def __init__(self):
        super().__init__("minimal_service")
        self.srv = self.create_service(AddTwoInts, "add_two_ints", self.add)
        self.slow = self.create_service(
            AddTwoInts, "add_async", self.add_async, callback_group=ReentrantCallbackGroup()
        )
        self.client = self.create_client(
            AddTwoInts, "add_two_ints", callback_group=MutuallyExclusiveCallbackGroup()
        )

    def add(self, request, response):
        response.sum = request.a + request.b
        return response

    async def add_async(self, request, response):
        answer = await self.client.call_async(request)
        response.sum = answer.sum * 10
        return response


class AddClient(Node):
    def __init__(self):
        super().__init__("minimal_client_async")
        self.cli = self.create_client(AddTwoInts, "add_two_ints")
        while not self.cli.wait_for_service(timeout_sec=1.0):
            self.get_logger().info("service not available, waiting again...")
        self.req = AddTwoInts.Request()

    def send_request(self, a, b):
        self.req.a = a
        self.req.b = b
        self.future = self.cli.call_async(self.req)
        rclpy.spin_until_future_complete(self, self.future)
        return self.future.result()


def main():
    with rclpy.init():
        server = AddServer()
        executor = MultiThreadedExecutor(num_threads=4)
        executor.add_node(server)
        spinner = threading.Thread(target=executor.spin)
        spinner.start()

        client = AddClient()
        assert client.send_request(41, 1).sum == 42

        # Waiting in one thread while another spins.
        assert client.cli.call(AddTwoInts.Request(a=1, b=2), timeout_sec=10.0).sum == 3

        # A callback added before or after the response arrives runs on the spinning thread.
        threads = []

        def on_answer(future):
            threads.append((threading.current_thread(), future.result().sum))

        first = client.cli.call_async(AddTwoInts.Request(a=2, b=2))
        first.add_done_callback(on_answer)
        rclpy.spin_until_future_complete(client, first)
        second = client.cli.call_async(AddTwoInts.Request(a=3, b=3))
        rclpy.spin_until_future_complete(client, second)
        second.add_done_callback(on_answer)
        while len(threads) < 2:
            rclpy.spin_once(client, timeout_sec=10.0)
        assert threads == [(threading.main_thread(), 4), (threading.main_thread(), 6)]

        # Coroutines as service callback and as client.
        asking = client.create_client(AddTwoInts, "add_async")
        assert asking.wait_for_service(10.0)

        async def ask():
            return (await asking.call_async(AddTwoInts.Request(a=4, b=5))).sum

        task = rclpy.get_global_executor().create_task(ask())
        rclpy.spin_until_future_complete(client, task, timeout_sec=10.0)
        assert task.result() == 90
        executor.shutdown()
        spinner.join()
    assert not rclpy.ok()
    print("done")


if __name__ == "__main__":
    main()
