"""Parameters of the controller manager that have no effect are named in the log."""

from teleopctl.control.controller_manager_node import unread_manager_parameters

READ = {"update_rate", "hardware_components_initial_state.inactive"}


def test_parameters_that_nothing_reads_are_named():
    given = ["update_rte", "handle_exceptions", "overruns.manage", "update_rate"]
    named = ["handle_exceptions", "overruns.manage", "update_rte"]
    assert unread_manager_parameters(given, READ) == named


def test_parameters_of_controllers_and_of_every_node_are_not():
    given = [
        "arm.type",
        "arm.gains.joint1.p",
        "diagnostics.threshold.controllers.periodicity.mean_error.warn",
        "use_sim_time",
        "hardware_components_initial_state.inactive",
        "defaults.switch_controller.strictness",
        "qos_overrides./joint_states.publisher.depth",
    ]
    assert unread_manager_parameters(given, READ) == []
