"""``moveit_configs_utils.moveit_configs_builder``."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from ament_index_python.packages import get_package_share_directory
from launch import SomeSubstitutionsType
from launch_param_builder import (
    ParameterBuilder,
    ParameterBuilderFileNotFoundError,
    load_xacro,
    load_yaml,
)
from launch_ros.parameter_descriptions import ParameterValue

from .default_pipelines import NAMES, default_pipeline, ompl_planners
from .moveit_configs import MoveItConfigs
from .substitutions import Xacro

_CONFIG = Path("config")
_CONTROLLERS = "_controllers.yaml"
_PLANNING = "_planning.yaml"

_Path = Path | str | None
_Mappings = Mapping[SomeSubstitutionsType, SomeSubstitutionsType]

_log = logging.getLogger(__name__)


class MoveItConfigsBuilder(ParameterBuilder):
    """Builder of MoveIt's parameters; each method returns the builder.

    A path is relative to the configuration package; without one, the file has its usual name.

    Args:
        robot_name: The robot.
        robot_description: The parameter for the URDF; others are named after it.
        package_name: The configuration package, by default ``NAME_moveit_config``.

    Raises:
        PackageNotFoundError: The package is unknown.
    """

    def __init__(
        self,
        robot_name: str,
        robot_description: str = "robot_description",
        package_name: str | None = None,
    ) -> None:
        super().__init__(package_name or f"{robot_name}_moveit_config")
        self._configs = MoveItConfigs(package_path=self._package_path)
        self._robot_name = robot_name
        self._parameter = robot_description
        self._urdf: Path | None = None
        self._urdf_mappings: _Mappings | None = None
        self._srdf: Path | None = None
        own = self._package_path / _CONFIG / f"{robot_name}.urdf.xacro"
        if own.exists():
            self._urdf = own
        self._read_setup_assistant(self._package_path / ".setup_assistant")
        if self._urdf is None:
            self._urdf = self._guessed("urdf")
        if self._srdf is None:
            self._srdf = self._guessed("srdf")

    def robot_description(self, file_path: _Path = None, mappings: _Mappings | None = None) -> Self:
        """Read the URDF from a file, which may be a xacro file with arguments."""
        assert self._urdf is not None
        path = self._urdf if file_path is None else self._package_path / file_path
        try:
            text = _description(path, mappings or self._urdf_mappings)
        except ParameterBuilderFileNotFoundError as error:
            _log.warning("%s; MoveIt takes it from the topic robot_description", error)
        else:
            self._configs.robot_description = {self._parameter: text}
        return self

    def robot_description_semantic(
        self, file_path: _Path = None, mappings: _Mappings | None = None
    ) -> Self:
        """Read the SRDF from a file, which may be a xacro file with arguments."""
        assert self._srdf is not None
        path = self._srdf if file_path is None else self._package_path / file_path
        self._configs.robot_description_semantic = {
            f"{self._parameter}_semantic": _description(path, mappings)
        }
        return self

    def robot_description_kinematics(self, file_path: _Path = None) -> Self:
        """Read the solvers of inverse kinematics from a file."""
        self._configs.robot_description_kinematics = {
            f"{self._parameter}_kinematics": self._file(file_path, "kinematics.yaml")
        }
        return self

    def joint_limits(self, file_path: _Path = None) -> Self:
        """Read limits of the joints from a file."""
        self._configs.joint_limits = {
            f"{self._parameter}_planning": self._file(file_path, "joint_limits.yaml")
        }
        return self

    def moveit_cpp(self, file_path: _Path = None) -> Self:
        """Read the parameters of MoveItCpp from a file."""
        self._configs.moveit_cpp = self._file(file_path, "moveit_cpp.yaml")
        return self

    def trajectory_execution(
        self, file_path: _Path = None, moveit_manage_controllers: bool = True
    ) -> Self:
        """Read the controllers from a file.

        Args:
            file_path: The file; without one, that of the package that is most likely meant.
            moveit_manage_controllers: Whether MoveIt may start and stop controllers.

        Raises:
            RuntimeError: Several files may be meant.
        """
        path = self._controllers() if file_path is None else self._package_path / file_path
        self._configs.trajectory_execution = {
            "moveit_manage_controllers": moveit_manage_controllers,
            **(load_yaml(path) if path is not None else {}),
        }
        return self

    def planning_scene_monitor(
        self,
        publish_planning_scene: bool = True,
        publish_geometry_updates: bool = True,
        publish_state_updates: bool = True,
        publish_transforms_updates: bool = True,
        publish_robot_description: bool = False,
        publish_robot_description_semantic: bool = False,
    ) -> Self:
        """Set which topics of the planning scene are published."""
        self._configs.planning_scene_monitor = {
            "publish_planning_scene": publish_planning_scene,
            "publish_geometry_updates": publish_geometry_updates,
            "publish_state_updates": publish_state_updates,
            "publish_transforms_updates": publish_transforms_updates,
            "publish_robot_description": publish_robot_description,
            "publish_robot_description_semantic": publish_robot_description_semantic,
        }
        return self

    def sensors_3d(self, file_path: _Path = None) -> Self:
        """Read the depth cameras from a file, if it exists."""
        path = self._package_path / (file_path or _CONFIG / "sensors_3d.yaml")
        if path.exists():
            found = load_yaml(path)
            if any(found["sensors"][:1]):
                self._configs.sensors_3d = found
        return self

    def planning_pipelines(
        self,
        default_planning_pipeline: str | None = None,
        pipelines: list[str] | None = None,
        load_all: bool = True,
    ) -> Self:
        """Read the planning pipelines from the package's files, or use MoveIt's defaults.

        Args:
            default_planning_pipeline: Pipeline for requests that name none; by default OMPL.
            pipelines: Which of them; by default those of the package.
            load_all: Whether MoveIt's own are added where `pipelines` are not given.

        Raises:
            RuntimeError: The default pipeline is none of them.
            ParameterBuilderFileNotFoundError: There is no file for one.
        """
        if pipelines is None:
            pipelines = self._names(_PLANNING)
            pipelines += [name for name in NAMES if load_all and name not in pipelines]
        default = default_planning_pipeline or ("ompl" if "ompl" in pipelines else pipelines[0])
        if default not in pipelines:
            raise RuntimeError(
                f"default_planning_pipeline: '{default}' is none of {', '.join(pipelines)}"
            )
        found = {name: self._pipeline(name) for name in pipelines}
        if "ompl" in found:
            found["ompl"].setdefault("planner_configs", ompl_planners())
        self._configs.planning_pipelines = {
            "planning_pipelines": pipelines,
            "default_planning_pipeline": default,
            **found,
        }
        return self

    def pilz_cartesian_limits(self, file_path: _Path = None) -> Self:
        """Read the limits of the Pilz planner from a file."""
        self._configs.pilz_cartesian_limits = {
            f"{self._parameter}_planning": self._file(file_path, "pilz_cartesian_limits.yaml")
        }
        return self

    def to_moveit_configs(self) -> MoveItConfigs:
        """Return the parameters, completed from the package's usual files.

        Raises:
            ParameterBuilderFileNotFoundError: Such a file does not exist.
        """
        configs = self._configs
        for name in (
            "robot_description",
            "robot_description_semantic",
            "robot_description_kinematics",
            "planning_pipelines",
            "trajectory_execution",
            "planning_scene_monitor",
            "sensors_3d",
            "joint_limits",
        ):
            if not getattr(configs, name):
                getattr(self, name)()
        has_pilz = "pilz_industrial_motion_planner" in configs.planning_pipelines
        if has_pilz and not configs.pilz_cartesian_limits:
            self.pilz_cartesian_limits()
        return configs

    # Any: values of any kind.
    def to_dict(self, include_moveit_configs: bool = True) -> dict[str, Any]:
        """Return all parameters, or only those of `ParameterBuilder`."""
        if include_moveit_configs:
            self._parameters.update(self.to_moveit_configs().to_dict())
        return self._parameters

    def _read_setup_assistant(self, path: Path) -> None:
        """Read the files' names from the package's ``.setup_assistant``."""
        if not path.exists():
            return
        config = (load_yaml(path) or {}).get("moveit_setup_assistant_config", {})
        urdf = config.get("urdf", config.get("URDF"))
        srdf = config.get("srdf", config.get("SRDF"))
        if urdf:
            if self._urdf is None:
                share = Path(get_package_share_directory(urdf["package"]))
                self._urdf = share / urdf["relative_path"]
            words = (urdf.get("xacro_args") or "").split()
            pairs = [word.split(":=", 1) for word in words]
            self._urdf_mappings = {name: value for name, value in pairs} or None  # noqa: C416
        if srdf:
            self._srdf = self._package_path / srdf["relative_path"]

    def _guessed(self, kind: str) -> Path:
        guess = _CONFIG / f"{self._robot_name}.{kind}"
        _log.warning("%s does not say which %s it has: %s", self._package_path, kind, guess)
        return self._package_path / guess

    def _file(self, given: _Path, usual: str) -> Any:
        return load_yaml(self._package_path / (given or _CONFIG / usual))

    def _names(self, ending: str) -> list[str]:
        files = sorted((self._package_path / _CONFIG).glob(f"*{ending}"))
        return [file.name.removesuffix(ending) for file in files]

    def _controllers(self) -> Path | None:
        folder = self._package_path / _CONFIG
        names = self._names(_CONTROLLERS)
        if not names:
            _log.warning("trajectory_execution: there is no %s/*%s", folder, _CONTROLLERS)
            return None
        likely = [name for name in ("moveit", "moveit2", self._robot_name) if name in names]
        if len(names) > 1 and not likely:
            raise RuntimeError(
                f"trajectory_execution: which of these files in {folder} is meant? "
                + ", ".join(f"{name}{_CONTROLLERS}" for name in names)
            )
        return folder / f"{(likely if len(names) > 1 else names)[0]}{_CONTROLLERS}"

    def _pipeline(self, name: str) -> dict[str, Any]:
        file = self._package_path / _CONFIG / f"{name}{_PLANNING}"
        if name in NAMES and not file.exists():
            return default_pipeline(name)
        found: dict[str, Any] = load_yaml(file)
        return found


def _description(path: Path, mappings: _Mappings | None) -> str | ParameterValue:
    plain = {
        name: value
        for name, value in (mappings or {}).items()
        if isinstance(name, str) and isinstance(value, str)
    }
    if len(plain) == len(mappings or {}):
        return load_xacro(path, plain)
    return ParameterValue(Xacro(str(path), mappings=mappings), value_type=str)
