"""``teleopctl lifecycle`` against managed nodes in processes of their own."""

import json
import os
import signal
import threading
import time
from functools import partial
from pathlib import Path

import pytest

from teleopctl.cli import main
from teleopctl.cli.completion import completing
from teleopctl.interfaces import get_message, get_service
from teleopctl.testing import eventually

PROGRAM = Path(__file__).parents[1] / "compat/programs/lifecycle.py"
STUBBORN = ["--ros-args", "-r", "__node:=stubborn", "-p", "stubborn:=true"]


@pytest.fixture(scope="module")
def nodes(shared_ros):
    """A managed node ``/lively``, one that cannot be configured, and one that is none."""
    lively = shared_ros.spawn_module("teleopctl.nodes", [str(PROGRAM)])
    shared_ros.spawn_module("teleopctl.nodes", [str(PROGRAM), *STUBBORN])
    shared_ros.spawn("run teleop_py_pkg simple_publisher").wait_for_line("Publishing")
    for name in ("lively", "stubborn"):
        eventually(partial(_answers, name), what=name)
    return lively


def _answers(name: str) -> bool:
    return main.run(["lifecycle", "get", name]) == 0


@pytest.fixture
def lifecycle(nodes, capsys):
    """Runs ``lifecycle``; returns status, output and errors."""

    def run(*words):
        capsys.readouterr()
        return (main.run(["lifecycle", *words]), *capsys.readouterr())

    yield run
    for transition in ("deactivate", "cleanup"):
        main.run(["lifecycle", "set", "lively", transition])


def test_nodes_are_those_with_a_life_cycle(lifecycle):
    assert lifecycle("nodes") == (0, "/lively\n/stubborn\n", "")
    assert lifecycle("nodes", "-a", "--no-daemon") == (0, "/lively\n/stubborn\n", "")
    assert lifecycle("nodes", "-c") == (0, "2\n", "")
    assert json.loads(lifecycle("nodes", "--json")[1]) == ["/lively", "/stubborn"]


def test_states_and_transitions_are_printed_as_ros2_prints_them(lifecycle):
    assert lifecycle("get", "lively") == (0, "unconfigured [1]\n", "")
    both = "/lively: unconfigured [1]\n/stubborn: unconfigured [1]\n"
    assert lifecycle("get") == (0, both, "")
    assert json.loads(lifecycle("get", "/lively", "--json")[1]) == [
        {"node": "/lively", "state": "unconfigured", "id": 1}
    ]
    assert lifecycle("list", "lively")[1] == (
        "- configure [1]\n\tStart: unconfigured\n\tGoal: configuring\n"
        "- shutdown [5]\n\tStart: unconfigured\n\tGoal: shuttingdown\n"
    )
    graph = lifecycle("list", "lively", "-a")[1]
    assert graph.count("- ") == 25
    assert "- transition_error [62]\n\tStart: errorprocessing\n\tGoal: finalized\n" in graph
    assert json.loads(lifecycle("list", "lively", "--json")[1])[0] == {
        "transition": "configure",
        "id": 1,
        "start": "unconfigured",
        "goal": "configuring",
    }


def test_a_transition_is_made_by_label_or_number_and_tab_knows_which(lifecycle):
    assert lifecycle("set", "lively", "configure") == (0, "Transitioning successful\n", "")
    assert completing.candidates(["lifecycle", "get"], "/li") == ["/lively"]
    offered = completing.candidates(["lifecycle", "set", "/lively"], "")
    assert offered == ["cleanup", "activate", "shutdown"]
    status, out, _ = lifecycle("set", "lively", "3", "--json")
    assert (status, json.loads(out)) == (
        0,
        {"node": "/lively", "transition": "activate", "state": "active", "id": 3},
    )


def test_what_is_refused_unknown_or_missing_says_so_and_fails(lifecycle):
    status, out, error = lifecycle("set", "stubborn", "configure")
    assert (status, out) == (1, "")
    assert error.startswith("teleopctl: Transitioning failed\n")
    assert lifecycle("set", "stubborn", "cleanup") == (
        1,
        "",
        "teleopctl: Unknown transition requested, available ones are:\n"
        "- configure [1]\n- shutdown [5]\n",
    )
    status, out, error = lifecycle("get", "livly")
    assert (status, out) == (1, "")
    assert error.startswith(
        "teleopctl: Node not found: '/livly'\n  There are /lively, /stubborn. Did you mean"
    )
    assert "is not a managed node" in lifecycle("list", "simple_publisher")[2]


@pytest.mark.skipif(os.name == "nt", reason="Windows cannot stop a process for a while")
def test_a_node_that_does_not_answer_is_named_and_costs_no_more_than_it_may(lifecycle, nodes):
    os.kill(nodes.pid, signal.SIGSTOP)
    try:
        alone = lifecycle("get", "lively", "--timeout", "0.2")
        among_all = lifecycle("get", "--timeout", "2")
        change = lifecycle("list", "lively", "--timeout", "0.2")
    finally:
        os.kill(nodes.pid, signal.SIGCONT)
    silent = "Node '/lively' did not answer within 0.2 s"
    assert (alone[:2], silent in alone[2]) == ((1, ""), True)
    assert among_all[:2] == (0, "/stubborn: unconfigured [1]\n")
    assert "Node '/lively' did not answer" in among_all[2]
    assert (change[:2], silent in change[2]) == ((1, ""), True)


def test_services_that_appear_shortly_after_their_node_are_waited_for(ros):
    """On a busy machine a command may see a node before its services, which appear one by one."""

    def answer(_request, response):
        transition = get_message("lifecycle_msgs/msg/TransitionDescription")()
        transition.transition.id, transition.transition.label = 1, "configure"
        response.available_transitions = [transition]
        return response

    def offer_when_asked():
        # The command's own node is in the graph when it looks for the services, which come late.
        eventually(lambda: any("_ros2cli" in each for each in ros.node.graph().node_names(True)))
        for type_, name in (
            ("ChangeState", "change_state"),
            ("GetState", "get_state"),
            ("GetAvailableStates", "get_available_states"),
            ("GetAvailableTransitions", "get_available_transitions"),
            ("GetAvailableTransitions", "get_transition_graph"),
        ):
            time.sleep(0.15)
            ros.node.create_service(get_service(f"lifecycle_msgs/srv/{type_}"), f"~/{name}", answer)

    name = ros.node.get_fully_qualified_name()
    ros.wait_for_nodes(name)
    offering = threading.Thread(target=offer_when_asked)
    offering.start()
    done = ros.run(f"lifecycle list {name} --include-hidden-nodes")
    offering.join()
    assert (done.stdout.splitlines()[:1], done.stderr) == (["- configure [1]"], "")
