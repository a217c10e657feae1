"""``teleopctl kinematics fk``, ``ik`` and ``jacobian``."""

import math

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.kinematics.source import (
    RobotOptions,
    Words,
    arm_of,
    numbers,
    read_robot,
    sorted_words,
)
from teleopctl.errors import UnavailableError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy as np
    import numpy.typing as npt

    from teleopctl.kinematics import Arm, IkSolution

    Array = npt.NDArray[np.float64]

_Joints = Annotated[
    list[str] | None,
    Argument(
        help="Robot's file with arguments of its xacro; then positions of the group's joints in "
        "rad or m, in their order or by name. Without a file the running robot; without "
        "positions the present ones, or those at rest.",
        metavar="[FILE [name:=value]…] [POSITION]… [JOINT=POSITION]…",
        complete="joints",
    ),
]
_Named = Annotated[
    str | None,
    Option("--named", help="Named state of the group.", metavar="STATE", complete="named_states"),
]
_Precision = Annotated[
    int, Option("-p", "--precision", help="Number of decimals.", metavar="DIGITS")
]
_Frame = Annotated[
    str | None,
    Option(
        "-f",
        "--frame",
        help="Link, or frame of /tf, in which poses are; by default the root link.",
        metavar="FRAME",
        complete="all_links",
    ),
]
_MOST_DIGITS = 17  # digits of a double
# Longest wait for an answer of move_group, in seconds.
_ANSWER_S = 5.0


def fk(
    words: _Joints = None,
    named: _Named = None,
    frame: _Frame = None,
    precision: _Precision = 3,
    *,
    robot: RobotOptions,
    as_json: AsJson = False,
) -> None:
    """Print the pose of the tool at joint positions, as ``tf2_echo`` prints transforms."""
    from teleopctl.kinematics import pose_transform
    from teleopctl.tf import pose_text

    _check_precision(precision)
    given = sorted_words(words or ())
    arm = _arm_at(given, named, robot)
    base, T_frame_root = frame_option(arm, frame, is_running=given.file is None)
    transform = pose_transform(T_frame_root @ arm.fk())
    if as_json:
        console.out_json({**_of_arm(arm, base), **_pose_document(T_frame_root @ arm.fk())})
        return
    console.out(f"Pose of '{arm.tool_name}' in '{base}', moved by group '{arm.group.name}'")
    console.out_text(pose_text(transform, precision))
    _note_collisions(arm)


def ik(
    words: Annotated[
        list[str],
        Argument(
            help="Robot's file with arguments of its xacro, or none for the running robot; then "
            "the position of the tool in m.",
            metavar="[FILE [name:=value]…] X Y Z",
            complete="files",
        ),
    ],
    rpy: Annotated[
        str | None,
        Option("--rpy", help="Rotation: roll, pitch, yaw in rad.", metavar="R,P,Y"),
    ] = None,
    quat: Annotated[
        str | None, Option("--quat", help="Rotation as a quaternion.", metavar="X,Y,Z,W")
    ] = None,
    frame: _Frame = None,
    start: Annotated[
        str | None,
        Option(
            "--start",
            help="Named state from which the search begins; by default the present positions.",
            metavar="STATE",
            complete="named_states",
        ),
    ] = None,
    allow_collisions: Annotated[
        bool, Option("--allow-collisions", help="Allow links to touch.")
    ] = False,
    direct: Annotated[
        bool, Option("--direct", help="Compute in this process even if move_group runs.")
    ] = False,
    precision: _Precision = 6,
    *,
    robot: RobotOptions,
    as_json: AsJson = False,
) -> int:
    """Print joint positions at which the tool has a pose; status 1 if there are none.

    Without a rotation any will do. What the joints of the group do not allow of a rotation is met
    as far as possible. What cannot be reached is answered with the nearest positions that were
    found, and with what keeps the tool from it. Where a move_group runs, it is asked by its service
    ``compute_ik``, with the obstacles of its scene.
    """
    _check_precision(precision)
    found = sorted_words(words)
    if found.names or found.joints or len(found.numbers) != 3:
        raise UsageError(
            f"A position is three numbers, x y z in m; got '{' '.join(_rest(found))}'",
            hint="teleopctl kinematics ik [FILE] X Y Z [--rpy R,P,Y]",
        )
    rotation = rotation_option(rpy, quat)
    read = read_robot(found, robot, needs_state=start is None)
    arm = arm_of(read, robot)
    if start is not None:
        arm.fk(start)
        arm.positions = arm.kinematics.present()
    base, T_frame_root = frame_option(arm, frame, is_running=found.file is None)
    from teleopctl.commander import target_pose

    target = target_pose(arm, T_frame_root, found.numbers, rotation)
    solution = arm.ik(
        target if rotation is not None else target[:3, 3], collisions=allow_collisions
    )
    if read.compute_ik and not direct:
        if rotation is None and len(arm.names) > 5:
            console.note("Without the scene of move_group, which takes whole poses only")
        else:
            solution = _by_move_group(
                read.compute_ik, arm, target, solution, allow_collisions=allow_collisions
            )
    if as_json:
        console.out_json(_solution_document(arm, base, T_frame_root, solution))
    elif solution.is_reached:
        console.out_lines(_joint_lines(arm, solution, precision))
        if rotation is not None and math.degrees(solution.rotation_error_rad) > 0.1:
            console.note(
                f"The position is reached; {len(arm.names)} joints do not serve the rotation: it "
                f"differs by {math.degrees(solution.rotation_error_rad):.1f} degrees"
            )
    else:
        is_turned = rotation is not None and solution.rotation_error_rad > 0.01
        lines = _not_reached(arm, base, T_frame_root, solution, precision, is_turned=is_turned)
        console.out_lines(lines)
    return 0 if solution.is_reached else 1


def jacobian(
    words: _Joints = None,
    named: _Named = None,
    precision: _Precision = 4,
    *,
    robot: RobotOptions,
    as_json: AsJson = False,
) -> None:
    """Print the geometric Jacobian of the tool in the axes of the root link.

    Rows are the tool's velocity in m/s, then its angular velocity in rad/s, at 1 rad/s or 1 m/s of
    each joint. Singular values are those of all rows, and of the linear ones; the manipulability is
    Yoshikawa's, the product of the singular values of what the group serves.
    """
    import numpy as np

    _check_precision(precision)
    arm = _arm_at(sorted_words(words or ()), named, robot)
    # After the robot is read, whose reader sets mujoco to load no renderer.
    from teleopctl.kinematics import served_task

    matrix = arm.jacobian()
    task = served_task(arm.kinematics)
    whole, linear = arm.kinematics.dimensions
    values = np.linalg.svd(matrix, compute_uv=False)
    linear_values = np.linalg.svd(matrix[:3], compute_uv=False)
    served = (values[:whole] if task.value == "pose" else linear_values[:linear]).tolist()
    smallest = min(served)
    condition = max(served) / smallest if smallest > 1e-12 * max(served) else math.inf
    if as_json:
        console.out_json(
            {
                **_of_arm(arm, arm.model.description.root),
                "jacobian": matrix.tolist(),
                "singular_values": values.tolist(),
                "linear_singular_values": linear_values.tolist(),
                "task": task.value,
                "manipulability": math.prod(served),
                "condition": condition if math.isfinite(condition) else None,
            }
        )
        return
    names = [*arm.names]
    width = max(precision + 4, *map(len, names))
    console.out(f"Jacobian of '{arm.tool_name}' in '{arm.model.description.root}'")
    console.out("    " + "  ".join(name.rjust(width) for name in names))
    for row, values_of_row in zip(("vx", "vy", "vz", "wx", "wy", "wz"), matrix, strict=True):
        cells = (f"{_rounded(value, precision):{width}.{precision}f}" for value in values_of_row)
        console.out(f"{row}  " + "  ".join(cells))
    console.out(f"Singular values: {_listed(values, precision)}")
    console.out(f"Singular values of the linear rows: {_listed(linear_values, precision)}")
    what = "pose" if task.value == "pose" else "position"
    console.out(f"Manipulability of the {what}: {math.prod(served):.{precision}g}")
    console.out(
        f"Condition of the {what}: {condition:.{precision}g}"
        if math.isfinite(condition)
        else f"Condition of the {what}: infinite (a singularity)"
    )


def _by_move_group(
    service: str, arm: "Arm", target: "Array", own: "IkSolution", *, allow_collisions: bool
) -> "IkSolution":
    """Return the answer of a running move_group; without a solution, our own with its reason.

    Raises:
        UnavailableError: It does not answer.
    """
    from dataclasses import replace

    import numpy as np

    from teleopctl.cli.command_node import brief_node
    from teleopctl.interfaces import get_service
    from teleopctl.kinematics import MoveItErrorCode, pose_transform, rotation_vector

    kind = get_service("moveit_msgs/srv/GetPositionIK")
    request = kind.Request()
    asked = request.ik_request
    asked.group_name, asked.ik_link_name = arm.group.name, arm.group.tip
    asked.avoid_collisions = not allow_collisions
    asked.robot_state.is_diff = True
    asked.robot_state.joint_state.name = list(arm.names)
    asked.robot_state.joint_state.position = arm.positions.tolist()
    asked.pose_stamped.header.frame_id = arm.model.description.root
    at = pose_transform(arm.kinematics.tip_pose(target))
    for part, values in (("position", at.translation), ("orientation", at.rotation)):
        for name, value in zip("xyzw", values, strict=False):
            setattr(getattr(asked.pose_stamped.pose, part), name, value)
    with brief_node() as node:
        future = node.create_client(kind, service).call_async(request)
        if not future.wait(_ANSWER_S) or (response := future.result()) is None:
            raise UnavailableError(
                f"{service} does not answer within {_ANSWER_S:g} s",
                hint="--direct computes in this process.",
            )
    code = response.error_code
    if code.val != MoveItErrorCode.SUCCESS:
        why = getattr(code, "message", "") or f"error code {code.val}"
        return replace(own, is_reached=False, binding=(why,))
    state = response.solution.joint_state
    found = dict(zip(state.name, map(float, state.position), strict=True))
    positions = np.array([found[name] for name in arm.names])
    reached = arm.fk(positions)
    turn = rotation_vector(target[:3, :3] @ reached[:3, :3].T)
    away_m = float(np.linalg.norm(target[:3, 3] - reached[:3, 3]))
    return replace(
        own,
        positions=positions,
        is_reached=True,
        position_error_m=away_m,
        rotation_error_rad=float(np.linalg.norm(turn)),
        binding=(),
        collisions=(),
    )


# --- shared with `move` -------------------------------------------------------------------------


def rotation_option(rpy: str | None, quat: str | None) -> "Array | None":
    """Return the rotation matrix, (3, 3), of ``--rpy`` or ``--quat``; None without any.

    Raises:
        UsageError: Both are given, or the numbers are no rotation.
    """
    from teleopctl.commander import rotation_of

    if rpy is not None and quat is not None:
        raise UsageError("Give --rpy or --quat, not both")
    return rotation_of(
        None if rpy is None else numbers(rpy, 3, "--rpy", "roll,pitch,yaw"),
        None if quat is None else numbers(quat, 4, "--quat", "x,y,z,w"),
    )


def frame_option(arm: "Arm", frame: str | None, *, is_running: bool) -> "tuple[str, Array]":
    """Return the name of a frame, and the pose of the root link in it, (4, 4).

    Args:
        arm: The arm, at its positions.
        frame: Name of a link, or of a frame of ``/tf`` if the robot runs; None for the root link.
        is_running: Whether the robot runs.

    Raises:
        NotFoundError: There is no such frame.
    """
    from teleopctl.commander import frame_transform, lookup_frame

    def lookup(frame: str, root: str) -> "Array | None":
        from teleopctl.cli.command_node import command_node

        with command_node() as node:
            return lookup_frame(node, frame, root)

    return frame_transform(arm, frame, lookup if is_running else None)


# --- parts --------------------------------------------------------------------------------------


def _check_precision(precision: int) -> None:
    if not 0 <= precision <= _MOST_DIGITS:
        raise UsageError(f"The precision is 0 to {_MOST_DIGITS} digits, not {precision}")


def _rest(words: Words) -> list[str]:
    return [
        *(f"{value:g}" for value in words.numbers),
        *(f"{name}={value:g}" for name, value in words.joints.items()),
        *words.names,
    ]


def _arm_at(words: Words, named: str | None, robot: RobotOptions) -> "Arm":
    """Return the arm at the positions on the command line."""
    if words.names:
        raise UsageError(
            f"'{words.names[0]}' is no file, no number and no JOINT=POSITION",
            hint="A file that is not below the current folder needs its path.",
        )
    if words.numbers and (words.joints or named):
        raise UsageError("Give positions in the joints' order, by name, or a named state")
    needs_state = not words.numbers and not named
    arm = arm_of(read_robot(words, robot, needs_state=needs_state), robot)
    if words.numbers:
        arm.positions = words.numbers
    elif named:
        arm.fk(named)
        arm.positions = arm.kinematics.present()
    if words.joints:
        arm.positions = words.joints
    beyond = [
        f"{name} {at:g} is outside {lower:.4g} to {upper:.4g}"
        for name, at, lower, upper in zip(
            arm.names, arm.positions, arm.lower, arm.upper, strict=True
        )
        if not lower - 1e-6 <= at <= upper + 1e-6
    ]
    if beyond:
        console.warn(f"Outside the joints' limits: {'; '.join(beyond)}")
    arm.kinematics.set(arm.positions)
    return arm


def _note_collisions(arm: "Arm") -> None:
    for first, second in arm.collisions():
        console.warn(f"'{first}' and '{second}' touch at these positions")


def _pose_document(pose: "Array") -> dict[str, console.Json]:
    from teleopctl.kinematics import pose_transform
    from teleopctl.tf import rpy_from_quaternion

    transform = pose_transform(pose)
    return {
        "position": dict(zip("xyz", transform.translation, strict=True)),
        "orientation": dict(zip("xyzw", transform.rotation, strict=True)),
        "rpy": list(rpy_from_quaternion(transform.rotation)),
    }


def _of_arm(arm: "Arm", frame: str) -> dict[str, console.Json]:
    return {
        "group": arm.group.name,
        "tip": arm.group.tip,
        "frame": frame,
        "joints": arm.kinematics.by_name(arm.positions),
    }


def _solution_document(
    arm: "Arm", frame: str, T_frame_root: "Array", solution: "IkSolution"
) -> dict[str, console.Json]:
    from teleopctl.kinematics import MoveItErrorCode

    code = MoveItErrorCode.SUCCESS if solution.is_reached else MoveItErrorCode.NO_IK_SOLUTION
    return {
        "group": arm.group.name,
        "tip": arm.group.tip,
        "frame": frame,
        "reached": solution.is_reached,
        "error_code": {"val": int(code), "name": code.name},
        "joints": arm.kinematics.by_name(solution.positions),
        "pose": _pose_document(T_frame_root @ arm.fk(solution.positions)),
        "position_error_m": solution.position_error_m,
        "rotation_error_rad": solution.rotation_error_rad,
        "binding": list(solution.binding),
    }


def _joint_lines(arm: "Arm", solution: "IkSolution", digits: int) -> list[str]:
    width = max(map(len, arm.names))
    return [
        f"{name:{width}}  {_rounded(at, digits):.{digits}f}"
        for name, at in zip(arm.names, solution.positions, strict=True)
    ]


def _not_reached(
    arm: "Arm",
    frame: str,
    T_frame_root: "Array",
    solution: "IkSolution",
    digits: int,
    *,
    is_turned: bool,
) -> list[str]:
    from teleopctl.kinematics import pose_transform
    from teleopctl.tf import rpy_from_quaternion

    nearest = pose_transform(T_frame_root @ arm.fk(solution.positions))
    away = f"{solution.position_error_m:.4g} m"
    turned = math.degrees(solution.rotation_error_rad)
    lines = [f"Not reached (NO_IK_SOLUTION, -31): {'; '.join(solution.binding) or 'not found'}"]
    if solution.position_error_m > 1e-3:
        lines.append(f"The nearest position that was found is {away} away:")
    elif is_turned:
        lines.append(f"The nearest pose that was found is turned by {turned:.1f} degrees:")
    else:
        lines.append("Reached, but for that, at:")
    return [
        *lines,
        f"- Translation in '{frame}': [{_listed(nearest.translation, 3)}]",
        f"- Rotation: in RPY (radian) [{_listed(rpy_from_quaternion(nearest.rotation), 3)}]",
        "Its joints:",
        *_joint_lines(arm, solution, digits),
    ]


def _listed(values: "Iterable[float]", digits: int) -> str:
    return ", ".join(f"{_rounded(value, digits):.{digits}f}" for value in values)


def _rounded(value: float, digits: int) -> float:
    """Return a number rounded for printing, without the sign of a zero."""
    return round(float(value), digits) + 0.0
