"""Actions as others see them: endpoints, keys and bytes, against what rmw_zenoh puts there.

The other side here is a bare Zenoh session that knows keys and bytes and nothing of ours. Names,
types, hashes and QoS were recorded from rclpy's own client and server.
"""

import struct
import threading
from typing import Any

import pytest
import zenoh

from teleopctl.node import ActionClient, CancelResponse, Future
from teleopctl.wire import decode_attachment, encode_attachment, open_session
from tests.node.actions.conftest import FIBONACCI

TYPE = "example_interfaces/action/Fibonacci"
_DDS = "example_interfaces::action::dds_::Fibonacci"
SEND_GOAL = (
    f"{_DDS}_SendGoal_/RIHS01_d1a57fb2a4afe8c21e34fb10db206f16ce6729b28531141472df92277c55b557"
)
GET_RESULT = (
    f"{_DDS}_GetResult_/RIHS01_1b0de0d5d29dc955d92f546706568428632771db13ec84c15ec1c1a59f424a57"
)
CANCEL_GOAL = (
    "action_msgs::srv::dds_::CancelGoal_/"
    "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a"
)
DEFAULT, STATUS = "::,10:,:,:,,", ":1:,1:,:,:,,"
ENDPOINTS = [
    ("send_goal", f"{TYPE}_SendGoal", DEFAULT),
    ("cancel_goal", "action_msgs/srv/CancelGoal", DEFAULT),
    ("get_result", f"{TYPE}_GetResult", DEFAULT),
    ("feedback", f"{TYPE}_FeedbackMessage", DEFAULT),
    ("status", "action_msgs/msg/GoalStatusArray", STATUS),
]
GOAL_ID = bytes(range(1, 17))
HEAD = bytes.fromhex("00010000")


@pytest.mark.parametrize(
    ("side", "kinds"), [("server", "SS SS SS MP MP"), ("client", "SC SC SC MS MS")]
)
def test_the_endpoints_are_those_of_rclpy_in_its_order(node, serve, side, kinds):
    if side == "server":
        serve()
    else:
        ActionClient(node, FIBONACCI, "fib")
    made = sorted((e for e in node.graph().endpoints if "/_action/" in e.name), key=lambda e: e.eid)
    assert [(e.kind.value, e.name, e.type_name) for e in made] == [
        (kind, f"/fib/_action/{name}", type_)
        for kind, (name, type_, _) in zip(kinds.split(), ENDPOINTS, strict=True)
    ]
    texts = [endpoint._token_key.rpartition("/")[2] for endpoint in node._endpoints[-5:]]
    assert texts == [qos for _, _, qos in ENDPOINTS]
    assert SEND_GOAL.endswith(f"/{made[0].type_hash}")


class Stranger:
    """Asks and listens by keys and bytes alone."""

    def __init__(self, domain: int, session: zenoh.Session) -> None:
        self.domain = domain
        self.session = session
        self.got: list[tuple[str, bytes]] = []
        self.got_all: Future[None] = Future()
        self._kept: list[Any] = []

    def listen(self, name: str) -> None:
        def hear(sample: zenoh.Sample) -> None:
            self.got.append((name, sample.payload.to_bytes()))
            if len(self.got) == 4:
                self.got_all.set_result(None)

        key = f"{self.domain}/fib/_action/{name}/*/*"
        handler = zenoh.handlers.Callback(hear, indirect=False)
        self._kept.append(self.session.declare_subscriber(key, handler))

    def ask(self, name: str, type_: str, request: bytes) -> Future[bytes]:
        answer: Future[bytes] = Future()

        def receive(reply: zenoh.Reply) -> None:
            assert reply.ok is not None
            assert reply.ok.attachment is not None
            meta = decode_attachment(reply.ok.attachment.to_bytes())
            assert meta is not None
            assert meta.sequence == 5
            answer.set_result(reply.ok.payload.to_bytes())

        querier = self.session.declare_querier(
            f"{self.domain}/fib/_action/{name}/{type_}",
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
        )
        is_routed = threading.Event()
        matching: Any = zenoh.handlers.Callback(lambda status: is_routed.set(), indirect=False)
        self._kept += (querier, querier.declare_matching_listener(matching))
        status: Any = querier.matching_status  # its annotation says bool
        assert status.matching or is_routed.wait(10)
        querier.get(
            zenoh.handlers.Callback(receive, indirect=False),
            payload=HEAD + request,
            attachment=encode_attachment(5, 1, bytes(16)),
        )
        return answer


def test_a_stranger_has_a_goal_executed_by_keys_and_bytes(context, executor, serve):
    def answer_to(future: Future[Any]) -> Any:
        executor.spin_until_future_complete(future, 10)
        assert future.done()
        return future.result()

    goals: list[Any] = []

    def execute(goal: Any) -> Any:
        goals.append(goal)
        goal.publish_feedback(FIBONACCI.Feedback(sequence=[8, 9]))
        goal.canceled() if goal.is_cancel_requested else goal.succeed()
        return FIBONACCI.Result(sequence=[3])

    serve(
        execute,
        cancel_callback=lambda goal: CancelResponse.ACCEPT,
        handle_accepted_callback=goals.append,
    )
    with open_session("client") as session:
        stranger = Stranger(context.domain_id, session)
        stranger.listen("feedback")
        stranger.listen("status")
        goal = GOAL_ID + struct.pack("<i", 7)
        accepted = answer_to(stranger.ask("send_goal", SEND_GOAL, goal))
        yes, sec, nanosec = struct.unpack("<4x?3xiI", accepted)
        assert (yes, goals[0].request.order) == (True, 7)
        result = stranger.ask("get_result", GET_RESULT, GOAL_ID)
        cancel = answer_to(stranger.ask("cancel_goal", CANCEL_GOAL, GOAL_ID + bytes(8)))
        code, count = struct.unpack_from("<4xb3xI", cancel)
        assert (code, count, cancel[12:28]) == (0, 1, GOAL_ID)
        at = struct.unpack_from("<iI", cancel, 28)
        assert at >= (sec, nanosec)  # stamped once more, when the goal was entered
        goals[0].execute()
        assert answer_to(result) == HEAD + bytes.fromhex("05000000 01000000 03000000")
        answer_to(stranger.got_all)
    feedback = [payload for name, payload in stranger.got if name == "feedback"]
    assert feedback == [HEAD + GOAL_ID + struct.pack("<3i", 2, 8, 9)]
    states = [payload for name, payload in stranger.got if name == "status"]
    assert [(payload[4], payload[8:24], payload[32]) for payload in states] == [
        (1, GOAL_ID, state) for state in (1, 3, 5)
    ]
