"""``teleopctl kinematics``: poses, Jacobians, workspaces and groups of robots."""

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Compute poses and joint positions of arms.",
    {
        "fk": Verb(
            f"{__name__}.queries:fk",
            "Print the pose of the tool at joint positions.",
            negative_numbers=True,
            examples=(
                "teleopctl kinematics fk",
                "teleopctl kinematics fk 0.5 0.2 -0.3",
                "teleopctl kinematics fk panda.urdf panda_joint4=-1.5 --tool panda_hand",
                "teleopctl kinematics fk ur.urdf.xacro ur_type:=ur5e name:=ur",
            ),
        ),
        "ik": Verb(
            f"{__name__}.queries:ik",
            "Print joint positions at which the tool has a pose.",
            negative_numbers=True,
            examples=(
                "teleopctl kinematics ik 0.3 0 0.4",
                "teleopctl kinematics ik 0.3 0 0.4 --rpy 3.14,0,0 --frame table",
                "teleopctl kinematics ik panda.urdf 0.5 0 0.3 --quat 1,0,0,0",
            ),
        ),
        "jacobian": Verb(
            f"{__name__}.queries:jacobian",
            "Print the Jacobian of the tool, and how near it is to a singularity.",
            negative_numbers=True,
            examples=("teleopctl kinematics jacobian", "teleopctl kinematics jacobian 0 0.5 -1"),
        ),
        "workspace": Verb(
            f"{__name__}.workspace:workspace",
            "Draw where the tool comes to.",
            examples=(
                "teleopctl kinematics workspace",
                "teleopctl kinematics workspace panda.urdf -o workspace.png",
            ),
        ),
        "srdf": Verb(
            f"{__name__}.semantics:srdf",
            "Write an SRDF for a robot, or check one.",
            examples=(
                "teleopctl kinematics srdf panda.urdf -o panda.srdf",
                "teleopctl kinematics srdf panda.urdf --check panda.srdf",
            ),
        ),
    },
    leaves_nothing=True,
)
