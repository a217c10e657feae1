"""The registry: what is found by which name, and what a broken plug-in may break."""

import sys
from importlib import import_module

import pytest

from teleopctl import plugins
from teleopctl.errors import BrokenPluginError, TeleopctlError, UnknownPluginError
from teleopctl.plugins import lookup, reloading
from tests.distributions import install

KINDS = plugins.kinds()
GROUP = plugins.CONTROLLERS.group
CONTROLLER = """
    from teleopctl.control.controllers.base import ControllerInterface

    class Mine(ControllerInterface):
        pass

    class Other:
        pass
"""


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder on the path for distributions; the registry reads the entry points anew."""
    monkeypatch.syspath_prepend(str(tmp_path))
    lookup.forget_entry_points()
    before = set(sys.modules)
    yield tmp_path
    lookup.forget_entry_points()
    for name in set(sys.modules) - before:
        if name.startswith("strange"):
            del sys.modules[name]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.noun)
def test_every_one_of_ours_can_be_loaded_and_is_what_its_kind_has_to_be(kind):
    for name in kind.builtin:
        found = plugins.load(kind, name)
        assert not kind.bases or lookup._is_one(found, kind), name


def test_every_kind_has_a_noun_and_a_group_of_its_own():
    assert len({kind.group for kind in KINDS}) == len({kind.noun for kind in KINDS}) == len(KINDS)


def test_ours_are_found_without_reading_entry_points(monkeypatch):
    monkeypatch.setattr(lookup, "_installed", None)
    for kind in KINDS:
        for name in kind.builtin:
            found = plugins.find(kind, name)
            assert found is not None
            assert (found.name, found.target, found.distribution) == (name, kind.builtin[name], "")


def test_a_strangers_plug_in_is_found_loaded_and_listed(site):
    install(site, "strange-arms", {GROUP: {"s/Mine": "strange:Mine"}}, {"strange.py": CONTROLLER})
    assert plugins.load(plugins.CONTROLLERS, "s/Mine").__name__ == "Mine"
    assert plugins.available(plugins.CONTROLLERS)["s/Mine"].distribution == "strange-arms"


def test_a_class_can_be_named_directly_where_its_kind_allows_that(site):
    (site / "strange.py").write_text(CONTROLLER.replace("\n    ", "\n"))
    assert plugins.load(plugins.CONTROLLERS, "strange:Mine").__name__ == "Mine"
    with pytest.raises(UnknownPluginError):
        plugins.load(plugins.VERBS, "strange:Mine")


def test_an_unknown_name_is_answered_with_those_that_there_are():
    with pytest.raises(UnknownPluginError, match="no controller 'joint_state_broadcaster'") as told:
        plugins.load(plugins.CONTROLLERS, "joint_state_broadcaster")
    assert "\n  joint_state_broadcaster/JointStateBroadcaster\n" in told.value.message
    assert "joint_state_broadcaster/JointStateBroadcaster" in str(told.value.hint)


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("strange_missing:Mine", "ModuleNotFoundError: No module named 'strange_missing'"),
        ("strange:Missing", "AttributeError"),
        ("strange_raises:Mine", "ZeroDivisionError"),
        ("strange_exits:Mine", "SystemExit: needs ROS"),
        ("strange:Other", "is not a subclass of .*ControllerInterface"),
        ("strange", "cannot be imported"),
        ("", "cannot be imported"),
    ],
)
def test_a_broken_plug_in_is_one_line_that_names_its_distribution(site, value, why):
    files = {"strange.py": CONTROLLER, "strange_raises.py": "1 / 0\n"}
    files["strange_exits.py"] = "raise SystemExit('needs ROS')\n"
    install(site, "strange-arms", {GROUP: {"s/Bad": value, "s/Mine": "strange:Mine"}}, files)
    with pytest.raises(BrokenPluginError, match=f"controller 's/Bad' of strange-arms: .*{why}"):
        plugins.load(plugins.CONTROLLERS, "s/Bad")
    assert plugins.load(plugins.CONTROLLERS, "s/Mine")


def test_metadata_that_cannot_be_read_concern_their_distribution_alone(site, caplog):
    install(site, "strange-arms", f"[{GROUP}]\nno value\n")
    folder = install(site, "unreadable-arms", {}) / "unreadable_arms-1.0.dist-info"
    (folder / "entry_points.txt").write_bytes(b"[teleopctl.\xff]")
    install(site, "other-arms", {GROUP: {"s/Mine": "strange:Mine"}}, {"strange.py": CONTROLLER})
    assert plugins.load(plugins.CONTROLLERS, "s/Mine")
    assert sorted(line.partition(" cannot be read: ")[0] for line in caplog.messages) == [
        "The plug-ins of strange-arms",
        "The plug-ins of unreadable-arms",
    ]


def test_of_two_distributions_with_one_name_the_first_by_name_wins_and_a_line_says_so(site, caplog):
    for name in ("b-arms", "a-arms"):
        install(site, name, {GROUP: {"s/Mine": "strange:Mine"}}, {"strange.py": CONTROLLER})
    for _ in range(2):
        found = plugins.find(plugins.CONTROLLERS, "s/Mine")
        assert found is not None
        assert found.distribution == "a-arms"
    assert caplog.messages == [
        f"Both a-arms and b-arms offer 's/Mine' in {GROUP}: that of a-arms is used"
    ]


def test_ours_win_over_a_strangers_of_the_same_name(site):
    install(site, "strange-arms", {plugins.VERBS.group: {"topic": "strange_missing:VERB"}})
    assert plugins.available(plugins.VERBS)["topic"].distribution == ""
    assert plugins.load(plugins.VERBS, "topic").verbs


def test_the_errors_are_of_the_kind_that_a_program_catches():
    assert issubclass(BrokenPluginError, TeleopctlError)
    assert not issubclass(BrokenPluginError, UnknownPluginError)


def test_of_ours_changed_files_are_read_again_with_their_dependents_but_not_base_classes(
    monkeypatch,
):
    kind, name = plugins.CONTROLLERS, "effort_controllers/GripperActionController"
    folder = "teleopctl.control.controllers"
    old = plugins.load(kind, name)
    plugins.remember_sources(kind, name)
    assert plugins.reload(kind, [name]).modules == []
    changed = [sys.modules[f"{folder}.{module}"] for module in ("base", "realtime_goal")]
    for module in changed:
        monkeypatch.setitem(reloading._imported_from, module, (0, 0, 0))
    reloaded = plugins.reload(kind, [name])
    try:
        assert {
            f"{folder}.{module}" for module in ("gripper_action_controller", "realtime_goal")
        } <= {*reloaded.modules}
        assert f"{folder}.base" not in reloaded.modules
        assert f"{folder}.pid" not in reloaded.modules
        assert plugins.load(kind, name) is not old
    finally:
        reloaded.undo()
    assert plugins.load(kind, name) is old


PACKAGE = {
    "strange/__init__.py": "",
    "strange/common.py": "SHARED = 1\n",
    "strange/alone.py": "bus = object()\n",
    "strange/inner/__init__.py": "",
    "strange/inner/arm.py": "from ..common import SHARED\nfrom .grip import Grip\n",
    "strange/inner/grip.py": CONTROLLER.replace("\n    ", "\n").replace("Mine", "Grip")
    + "\n\ndef later():\n    import strange.late\n",
    "strange/late.py": "TEXT = 1\n",
    "strange/arm.py": "from strange.inner.arm import Grip, SHARED\nfrom strange import alone\n",
}


@pytest.mark.parametrize(
    ("edited", "again"),
    [
        ("common", {"common", "inner.arm", "arm"}),
        ("inner.grip", {"inner.grip", "inner.arm", "arm"}),
        ("late", {"late", "inner.grip", "inner.arm", "arm"}),
        ("alone", {"alone", "arm"}),
        ("arm", {"arm"}),
    ],
)
def test_a_changed_module_is_imported_again_with_all_that_import_it(site, edited, again):
    for path, text in PACKAGE.items():
        (site / path).parent.mkdir(exist_ok=True, parents=True)
        (site / path).write_text(text)
    name = "strange.arm:Grip"
    plugins.load(plugins.CONTROLLERS, name)
    import_module("strange.late")
    plugins.remember_sources(plugins.CONTROLLERS, name)
    with (site / f"strange/{edited.replace('.', '/')}.py").open("a") as file:
        file.write("# edited\n")
    reloaded = plugins.reload(plugins.CONTROLLERS, [name], only_changed=True)
    # A module that is imported later is dropped, and imported again then.
    expected = {f"strange.{module}" for module in again} - {"strange.late"}
    assert set(reloaded.modules) == expected
    assert plugins.reload(plugins.CONTROLLERS, [name], only_changed=True).modules == []
