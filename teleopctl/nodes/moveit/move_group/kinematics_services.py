"""Services ``compute_fk``, ``compute_ik`` and ``check_state_validity``."""

from __future__ import annotations

from typing import Any

import numpy as np

from teleopctl.commander import read_pose, write_pose
from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message, get_service, to_nanoseconds
from teleopctl.kinematics import (
    Approach,
    CollisionScene,
    CompiledScene,
    JointGroup,
    MoveItErrorCode,
    PlanningError,
    moved_links,
)
from teleopctl.nodes.moveit.move_group import messages
from teleopctl.nodes.moveit.move_group.constraints import ConstraintSet
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.goals import unreached

# Solutions that are tried until one also meets the constraints of a request.
_MOST_TRIES = 20

# Any, here and below: message classes are generated at run time from definitions.
_Contact: Any = get_message("moveit_msgs/msg/ContactInformation")
ROBOT_LINK, WORLD_OBJECT, ROBOT_ATTACHED = 0, 1, 2


class KinematicsServices:
    """Forward and inverse kinematics and validity of states, as MoveIt's services.

    Args:
        context: Robot, state and scene.
    """

    def __init__(self, context: MoveGroupContext) -> None:
        self._context = context
        self._log = context.node.get_logger()
        for type_name, name, callback in (
            ("moveit_msgs/srv/GetPositionFK", "compute_fk", self._compute_fk),
            ("moveit_msgs/srv/GetPositionIK", "compute_ik", self._compute_ik),
            ("moveit_msgs/srv/GetStateValidity", "check_state_validity", self._check_validity),
        ):
            context.node.create_service(get_service(type_name), name, callback)

    # --- forward --------------------------------------------------------------------------------

    def _compute_fk(self, request: Any, response: Any) -> Any:
        try:
            self._fill_fk(request, response)
            response.error_code = messages.error_code(MoveItErrorCode.SUCCESS)
        except PlanningError as error:
            response.error_code = self._refused("compute_fk", error)
        return response

    def _fill_fk(self, request: Any, response: Any) -> None:
        context = self._context
        names = list(request.fk_link_names)
        if not names:
            raise PlanningError(
                "No links specified for FK request", MoveItErrorCode.INVALID_LINK_NAME
            )
        to_frame = np.linalg.inv(context.frame(request.header.frame_id))
        with context.lock:
            positions = context.positions(request.robot_state)
            scene = context.scene_of(request.robot_state)
            model = scene.model
            before = model.positions()
            model.set_positions(positions)
            try:
                unknown = []
                for name in names:
                    pose = scene.frame(name)
                    if pose is None:
                        unknown.append(name)
                        continue
                    stamped: Any = get_message("geometry_msgs/msg/PoseStamped")()
                    stamped.header.frame_id = request.header.frame_id or context.planning_frame
                    stamped.header.stamp = context.node.get_clock().now().to_msg()
                    stamped.pose = write_pose(to_frame @ pose)
                    response.pose_stamped.append(stamped)
                    response.fk_link_names.append(name)
            finally:
                model.set_positions(before)
        if unknown:
            raise PlanningError(
                f"The robot has no links {', '.join(unknown)}", MoveItErrorCode.INVALID_LINK_NAME
            )

    # --- inverse --------------------------------------------------------------------------------

    def _compute_ik(self, request: Any, response: Any) -> Any:
        try:
            response.solution = self._solve(request.ik_request)
            response.error_code = messages.error_code(MoveItErrorCode.SUCCESS)
        except PlanningError as error:
            response.error_code = self._refused("compute_ik", error)
        return response

    def _solve(self, request: Any) -> Any:
        context = self._context
        group = context.group(request.group_name)
        link, stamped = _ik_target(request)
        try:
            pose = read_pose(stamped.pose, "The pose")
        except UsageError as error:
            raise PlanningError(error.message, MoveItErrorCode.NO_IK_SOLUTION) from error
        target = context.frame(stamped.header.frame_id) @ pose
        timeout_s = 1e-9 * to_nanoseconds(request.timeout) or None
        with context.lock:
            positions = context.positions(request.robot_state)
            scene = context.scene_of(request.robot_state)
            compiled = scene.compiled()
            compiled.model.set_positions(positions)
            solver = context.solver(group, compiled, link, avoid=bool(request.avoid_collisions))
            kinematics = solver.kinematics
            constraints = ConstraintSet(context, request.constraints, kinematics)
            constraints.narrow(kinematics)
            start = kinematics.vector(positions)
            generator = np.random.default_rng(0)
            for _ in range(_MOST_TRIES if constraints else 1):
                found = solver.solve(target, start, timeout_s=timeout_s)
                if not found.is_reached:
                    problem, _ = unreached(solver, target, start, found)
                    raise PlanningError(problem, MoveItErrorCode.NO_IK_SOLUTION)
                kinematics.set(found.positions)
                violated = constraints.violation(found.positions)
                if not violated:
                    break
                start = kinematics.random(generator)
            else:
                raise PlanningError(
                    f"No solution of {_MOST_TRIES} meets the constraints: {violated}",
                    MoveItErrorCode.NO_IK_SOLUTION,
                )
            solved = compiled.model.positions()
            solved.update(
                compiled.model.joints.positions({**solved, **kinematics.by_name(found.positions)})
            )
        return messages.write_robot_state(solved, context.planning_frame)

    # --- validity -------------------------------------------------------------------------------

    def _check_validity(self, request: Any, response: Any) -> Any:
        context = self._context
        response.valid = True
        try:
            group = context.group(request.group_name) if request.group_name else None
            with context.lock:
                positions = context.positions(request.robot_state)
                scene = context.scene_of(request.robot_state)
                compiled = scene.compiled()
                compiled.model.set_positions(positions)
                touching = compiled.clearance.collisions()
                if group is not None:
                    moved = moved_bodies(compiled, scene, group)
                    touching = [one for one in touching if moved & {*one.bodies}]
                response.contacts = [self._contact(one, scene, compiled) for one in touching]
                constraints = ConstraintSet(context, request.constraints, None, compiled.model)
                response.constraint_result = constraints.results()
        except PlanningError as error:
            self._refused("check_state_validity", error)
            response.valid = False
            return response
        if response.contacts or not all(one.result for one in response.constraint_result):
            response.valid = False
        return response

    def _contact(self, one: Approach, scene: CollisionScene, compiled: CompiledScene) -> Any:
        contact = _Contact()
        contact.header.frame_id = self._context.planning_frame
        contact.header.stamp = self._context.node.get_clock().now().to_msg()
        point = compiled.model.to_root(one.point)
        normal = compiled.model.R_root_world @ one.normal
        contact.position.x, contact.position.y, contact.position.z = point.tolist()
        contact.normal.x, contact.normal.y, contact.normal.z = normal.tolist()
        contact.depth = -one.distance_m
        contact.contact_body_1, contact.contact_body_2 = one.bodies
        contact.body_type_1, contact.body_type_2 = (body_type(n, scene) for n in one.bodies)
        return contact

    def _refused(self, service: str, error: PlanningError) -> Any:
        self._log.warning(f"{service}: {error.message}")
        return messages.error_code(error.code, error.message)


def body_type(name: str, scene: CollisionScene) -> int:
    """Return the kind of body of a name, as of ``moveit_msgs/msg/ContactInformation``."""
    if name in scene.attached:
        return ROBOT_ATTACHED
    return WORLD_OBJECT if name in scene.objects else ROBOT_LINK


def moved_bodies(compiled: CompiledScene, scene: CollisionScene, group: JointGroup) -> set[str]:
    """Return the links that a group moves, and what they carry."""
    moved = {*moved_links(group, compiled.model.description)}
    return moved | {name for name, one in scene.attached.items() if one.link in moved}


def _ik_target(request: Any) -> tuple[str, Any]:
    """Return the link and the pose that a request is about.

    Raises:
        PlanningError: The request has several.
    """
    stamped = list(request.pose_stamped_vector)
    links = list(request.ik_link_names)
    if len(stamped) > 1:
        raise PlanningError(
            f"{len(stamped)} poses at once are not supported: ask for one group at a time",
            MoveItErrorCode.NO_IK_SOLUTION
            if len(stamped) == len(links)
            else MoveItErrorCode.INVALID_LINK_NAME,
        )
    if stamped:
        return (links[0] if links else ""), stamped[0]
    return request.ik_link_name, request.pose_stamped
