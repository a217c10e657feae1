"""Read the joint states of a bag into numpy arrays: python read_bag.py BAG"""

import sys

import numpy as np

import teleopctl

times_s, positions = [], []
for record in teleopctl.read_bag(sys.argv[1], ["/joint_states"]):
    times_s.append(record.log_time_ns * 1e-9)
    positions.append(record.message.position)

times = np.array(times_s)
joints = np.array(positions)
print(f"{len(times)} messages of {joints.shape[1]} joints over {np.ptp(times):.1f} s")
print("smallest positions:", joints.min(axis=0).round(3))
print("largest positions: ", joints.max(axis=0).round(3))
