"""Goals from their sending to their end, between a server and a client."""

import threading
from typing import Any

import pytest

from teleopctl.interfaces import get_action, get_message
from teleopctl.node import (
    ActionClient,
    ActionServer,
    CancelResponse,
    Future,
    GoalEvent,
    GoalResponse,
    GoalState,
    InvalidGoalTransitionError,
    MultiThreadedExecutor,
    Parameter,
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
    qos_profile_action_status_default,
)
from teleopctl.node.actions.client import FeedbackCallbacks
from teleopctl.testing import eventually
from tests.node.actions.conftest import FIBONACCI

UUID = get_message("unique_identifier_msgs/msg/UUID")
STATES = get_message("action_msgs/msg/GoalStatusArray")
CLOCK = get_message("rosgraph_msgs/msg/Clock")


def accept(_: object) -> CancelResponse:
    return CancelResponse.ACCEPT


def hold(goals: list[Any]) -> Any:
    """A callback of accepted goals that executes none."""
    return goals.append


def states_of(message: Any) -> list[int]:
    return [entry.status for entry in message.status_list]


def test_a_goal_runs_with_feedback_to_its_result(node, serve, send, result_of, spin_until):
    told: list[Any] = []
    node.create_subscription(STATES, "fib/_action/status", told.append, 10)

    def execute(goal: Any) -> Any:
        for length in range(1, 4):
            goal.publish_feedback(FIBONACCI.Feedback(sequence=range(length)))
        goal.succeed()
        return FIBONACCI.Result(sequence=[0, 1, 1])

    serve(execute)
    feedback: list[Any] = []
    handle = send(feedback_callback=feedback.append)
    assert handle.accepted
    answer = result_of(handle)
    assert (answer.status, list(answer.result.sequence)) == (GoalState.SUCCEEDED, [0, 1, 1])
    assert len(feedback) == 3  # what came before the result was passed on before
    spin_until(lambda: len(told) == 3)
    assert [list(one.feedback.sequence) for one in feedback] == [[0], [0, 1], [0, 1, 2]]
    assert feedback[0].goal_id == handle.goal_id
    assert [states_of(message) for message in told] == [[1], [2], [4]]
    spin_until(lambda: handle.status == GoalState.SUCCEEDED)


def test_feedback_that_waits_when_the_result_comes_is_delivered_and_later_one_is_not(
    node, serve, client, spin_until
):
    goals: list[Any] = []
    serve(handle_accepted_callback=hold(goals))
    feedback: list[Any] = []
    assert client.wait_for_server(10)
    future = client.send_goal_async(FIBONACCI.Goal(), feedback.append)
    spin_until(future.done)
    result = future.result().get_result_async()
    spin_until(lambda: goals)
    goals[0].executing()
    spin_until(lambda: future.result().status == GoalState.EXECUTING)
    subscription = next(s for s in node.subscriptions if s.topic_name.endswith("feedback"))
    for _ in range(2):
        goals[0].publish_feedback(FIBONACCI.Feedback())
    name, kind = subscription.topic_name, FIBONACCI.Impl.FeedbackMessage
    node.create_publisher(kind, name, 10).publish(b"nothing that can be read")
    goals[0].succeed(FIBONACCI.Result(sequence=[7]))
    spin_until(result.done)
    assert len(feedback) == 2
    goals[0].publish_feedback(FIBONACCI.Feedback())
    spin_until(lambda: not subscription.pending())
    assert len(feedback) == 2


@pytest.mark.parametrize("answer", [GoalResponse.REJECT, "nonsense"])
def test_a_goal_that_is_not_accepted_is_rejected_and_has_no_result(serve, send, result_of, answer):
    serve(goal_callback=lambda goal: answer, handle_accepted_callback=pytest.fail)
    handle = send()
    assert (handle.accepted, handle.stamp.sec, handle.stamp.nanosec) == (False, 0, 0)
    assert result_of(handle).status == GoalState.UNKNOWN


def test_an_id_that_is_known_is_rejected_without_asking(serve, send):
    asked: list[Any] = []

    def judge(goal: Any) -> GoalResponse:
        asked.append(goal)
        return GoalResponse.ACCEPT

    serve(goal_callback=judge)
    goal_id = UUID(uuid=bytes(range(16)))
    first = send(goal_uuid=goal_id)
    assert (first.accepted, send(goal_uuid=goal_id).accepted) == (True, False)
    assert len(asked) == 1


def test_an_exception_aborts_the_goal_and_is_told(serve, send, result_of, said):
    def execute(goal: Any) -> Any:
        raise RuntimeError("the gripper is gone")

    serve(execute)
    answer = result_of(send())
    assert (answer.status, list(answer.result.sequence)) == (GoalState.ABORTED, [])
    told = said()
    assert "Error raised in execute callback: the gripper is gone" in told
    assert "Goal state not set, assuming aborted" in told


def test_a_goal_without_an_end_state_is_aborted_with_the_result_it_returned(serve, send, result_of):
    serve(lambda goal: FIBONACCI.Result(sequence=[5]))
    answer = result_of(send())
    assert (answer.status, list(answer.result.sequence)) == (GoalState.ABORTED, [5])


def test_a_result_that_is_given_with_the_end_state_counts(serve, send, result_of):
    serve(lambda goal: goal.succeed(FIBONACCI.Result(sequence=[1])))
    answer = result_of(send())
    assert (answer.status, list(answer.result.sequence)) == (GoalState.SUCCEEDED, [1])


def test_an_end_state_without_a_result_gives_the_default_one(serve, send, result_of):
    serve(lambda goal: goal.succeed())
    answer = result_of(send())
    assert (answer.status, list(answer.result.sequence)) == (GoalState.SUCCEEDED, [])


def test_values_of_other_types_are_refused(serve, send, client, result_of):
    refused: list[bool] = []

    def execute(goal: Any) -> Any:
        for attempt in (goal.publish_feedback, goal.succeed):
            with pytest.raises(TypeError):
                attempt("other")
            refused.append(goal.is_active)
        goal.succeed()
        return FIBONACCI.Goal()

    serve(execute)
    with pytest.raises(TypeError):
        client.send_goal_async("other")
    assert result_of(send()).status == GoalState.SUCCEEDED
    assert refused == [True, True]


def test_every_callback_may_be_a_coroutine(serve, client, executor, spin_until):
    step = executor.create_future()

    async def execute(goal: Any) -> Any:
        await step
        goal.succeed()
        return FIBONACCI.Result(sequence=[4])

    async def judge(goal: Any) -> GoalResponse:
        return GoalResponse.ACCEPT

    async def begin(goal: Any) -> None:
        goal.execute()

    serve(execute, goal_callback=judge, handle_accepted_callback=begin)
    answers: list[Any] = []

    async def ask() -> None:
        handle = await client.send_goal_async(FIBONACCI.Goal())
        answers.append(handle.status)
        step.set_result(None)
        answers.append(await handle.get_result_async())

    assert client.wait_for_server(10)
    executor.create_task(ask)
    spin_until(lambda: len(answers) == 2)
    assert (answers[1].status, list(answers[1].result.sequence)) == (GoalState.SUCCEEDED, [4])


def test_a_goal_is_cancelled_while_it_runs_in_another_thread(context, node, serve, client):
    executor = MultiThreadedExecutor(3, context=context)
    executor.add_node(node)
    began, cancelled = threading.Event(), threading.Event()

    def execute(goal: Any) -> Any:
        began.set()
        assert cancelled.wait(10)
        assert goal.is_cancel_requested
        goal.canceled()
        return FIBONACCI.Result()

    serve(execute, cancel_callback=accept)
    spinning = threading.Thread(target=executor.spin)
    spinning.start()
    try:
        assert client.wait_for_server(10)
        handle = client.send_goal_async(FIBONACCI.Goal()).wait_for_response(10)
        assert began.wait(10)
        answer = handle.cancel_goal()
        assert answer.return_code == 0
        assert [info.goal_id for info in answer.goals_canceling] == [handle.goal_id]
        cancelled.set()
        assert handle.get_result().status == GoalState.CANCELED
    finally:
        cancelled.set()
        executor.shutdown()
        spinning.join()


def test_a_refusal_to_cancel_leaves_that_goal_and_no_other(serve, send, client, spin_until):
    goals: list[Any] = []
    serve(
        handle_accepted_callback=hold(goals),
        cancel_callback=lambda goal: CancelResponse(1 + goal.request.order % 2),
    )
    handles = [send(order) for order in (2, 4, 5)]
    every = client.request_cancel(UUID())
    spin_until(every.done)
    answer = every.result()
    assert answer.return_code == 0
    assert [info.goal_id for info in answer.goals_canceling] == [handles[2].goal_id]
    assert [goal.status for goal in goals] == [1, 1, 3]


def test_the_codes_of_cancelling_one_goal_tell_unknown_and_ended_ones(
    serve, send, client, result_of, spin_until
):
    serve(cancel_callback=accept)
    handle = send()
    result_of(handle)
    codes = []
    for goal_id in (UUID(uuid=[9] * 16), handle.goal_id):
        future = client.request_cancel(goal_id)
        spin_until(future.done)
        codes.append((future.result().return_code, len(future.result().goals_canceling)))
    assert codes == [(2, 0), (3, 0)]


def test_a_deferred_goal_is_executed_when_the_program_says_so(serve, send, result_of, executor):
    goals: list[Any] = []
    serve(handle_accepted_callback=hold(goals), cancel_callback=accept)
    handle = send()
    with pytest.raises(InvalidGoalTransitionError):
        goals[0].succeed()
    # Without an executor at the moment: it is done when there is one again.
    served = goals[0]._server._node
    executor.remove_node(served)
    goals[0].execute()
    executor.add_node(served)
    assert result_of(handle).status == GoalState.SUCCEEDED
    with pytest.raises(InvalidGoalTransitionError):
        goals[0].execute()


def test_a_goal_that_was_cancelled_before_it_ran_is_still_executed(serve, send, result_of):
    goals: list[Any] = []

    def execute(goal: Any) -> Any:
        assert goal.is_cancel_requested
        goal.canceled()
        return FIBONACCI.Result()

    serve(execute, handle_accepted_callback=hold(goals), cancel_callback=accept)
    handle = send()
    goals[0]._update_state(GoalEvent.CANCEL_GOAL)  # as spot_ros2's base does
    goals[0].execute()
    assert result_of(handle).status == GoalState.CANCELED


def test_a_result_is_kept_for_its_time_after_the_end_on_the_nodes_clock(
    make_node, executor, spin_until
):
    node = make_node("server", parameter_overrides=[Parameter("use_sim_time", value=True)])
    clock = make_node("clock").create_publisher(CLOCK, "/clock", 10)

    def set_time(sec: int) -> None:
        message = CLOCK()
        message.clock.sec = sec
        clock.publish(message)
        spin_until(lambda: node.get_clock().now().nanoseconds == sec * 10**9)

    set_time(100)
    goals: list[Any] = []
    server = ActionServer(
        node, FIBONACCI, "fib", lambda goal: None, result_timeout=10,
        handle_accepted_callback=goals.append,
    )  # fmt: skip
    client = ActionClient(make_node("client"), FIBONACCI, "fib")
    assert client.wait_for_server(10)
    future = client.send_goal_async(FIBONACCI.Goal())
    spin_until(future.done)
    spin_until(lambda: goals)
    goals[0].executing()
    set_time(200)  # a running goal never expires
    goals[0].succeed(FIBONACCI.Result(sequence=[1]))

    def status() -> int:
        handle = future.result()
        assert handle is not None
        result: Future[Any] = handle.get_result_async()
        spin_until(result.done)
        answer = result.result()
        assert answer is not None
        return int(answer.status)

    set_time(209)
    assert (status(), goals[0].status) == (GoalState.SUCCEEDED, GoalState.SUCCEEDED)
    set_time(210)
    spin_until(lambda: goals[0].status == GoalState.UNKNOWN)
    assert status() == GoalState.UNKNOWN
    server.destroy()


def test_a_late_joiner_is_told_the_states_of_goals(node, serve, send, result_of, spin_until):
    serve()
    result_of(send())
    late: list[Any] = []
    node.create_subscription(
        STATES, "fib/_action/status", late.append, qos_profile_action_status_default
    )
    spin_until(lambda: late)
    assert states_of(late[-1]) == [GoalState.SUCCEEDED]


def test_a_client_that_blocks_in_a_callback_is_answered(context, serve, node, client):
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)
    serve()
    assert client.wait_for_server(10)
    answer = executor.create_task(lambda: client.send_goal(FIBONACCI.Goal(order=2)))
    executor.spin_until_future_complete(answer, 10)
    executor.shutdown(10)
    response = answer.result()
    assert response is not None
    assert list(response.result.sequence) == [0, 1]


def test_it_is_told_when_the_server_of_a_goal_goes_away(serve, send, spin_until, said):
    server = serve(handle_accepted_callback=lambda goal: None)
    handle = send()
    future = handle.get_result_async()
    spin_until(lambda: not server._services[2].pending())
    server.destroy()
    what = f"the request for the result of goal {handle._key.hex()}: none is there"
    eventually(lambda: what in said())
    assert not future.done()


def test_a_server_is_ready_while_it_is_there_and_not_for_clients_of_another_type(
    node, serve, client
):
    another = get_action("action_tutorials_interfaces/action/Fibonacci")
    assert not client.wait_for_server(0)
    server = serve()
    assert client.wait_for_server(10)
    with ActionClient(node, another, "fib") as other:
        assert not other.server_is_ready()
    server.destroy()
    server.destroy()
    assert not client.server_is_ready()


def test_actions_are_found_by_name_and_by_node(make_node, context):
    served, asking = make_node("one"), make_node("two", namespace="/ns")
    with ActionServer(served, FIBONACCI, "~/fib", lambda goal: None) as server:
        client = ActionClient(asking, FIBONACCI, "fib")
        assert (server.action_name, client.action_name) == ("/one/fib", "/ns/fib")
        type_ = ["example_interfaces/action/Fibonacci"]
        assert context.wait_for_graph(lambda graph: len(graph.action_names_and_types()) == 2, 10)
        assert get_action_names_and_types(asking) == [("/ns/fib", type_), ("/one/fib", type_)]
        by_server = get_action_server_names_and_types_by_node
        by_client = get_action_client_names_and_types_by_node
        assert by_server(asking, "one", "/") == [("/one/fib", type_)]
        assert by_client(asking, "one", "/") == []
        assert by_client(asking, "two", "/ns") == [("/ns/fib", type_)]
    assert context.wait_for_graph(lambda graph: len(graph.action_names_and_types()) == 1, 10)


def test_a_result_comes_when_the_last_feedback_is_handled_in_the_same_instant():
    """That feedback would be waited for, though it has been handled, and no other one comes."""
    callbacks: FeedbackCallbacks[Any] = FeedbackCallbacks()
    callbacks.add(b"goal", lambda _message: None)
    executor = threading.Thread(target=callbacks.dispatch, args=(None,))
    has_ended = threading.Event()

    def count_queued() -> int:
        executor.start()
        executor.join(0.1)
        return 1

    callbacks.remove(b"goal", count_queued, has_ended.set)
    executor.join()
    assert has_ended.is_set()
