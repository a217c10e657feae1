"""Move the arm of the running robot: teleopctl launch sim.yaml -d; python move_arm.py"""

import numpy as np

from teleopctl import ExecutionError, PlanningError, RunningArm

with RunningArm() as arm:
    try:
        reached = arm.move(to=[0.3, 0.9, 1.4])  # m, in the root link's frame
        print(reached.text)
        arm.move(to=[0, 0, -0.05], frame="claw_support", linear=True, speed=0.2)
        arm.gripper("open")

        plan = arm.plan(joints={"joint_1": 0.5}, speed=0.5)  # moves nothing yet
        print(f"{plan.duration_s:.2f} s by {plan.planner}")
        arm.execute(plan)

        T_root_tool = arm.pose()  # (4, 4), as measured
        T_root_tool[:3, 3] += np.array([0.0, 0.0, 0.1])
        arm.move(to=T_root_tool)
        print(arm.move(named="home").joints)
    except PlanningError as error:
        print(f"There is no such motion ({error.code.name}): {error.message}")
    except ExecutionError as error:
        print(f"{error.message}; the joints are at {error.result.joints}")
