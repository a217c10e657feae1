"""Print nodes as they come and go: python watch_graph.py"""

import teleopctl

before: set[str] = set()
for graph in teleopctl.watch_graph():
    now = set(graph.node_names())
    for name in sorted(now - before):
        print("+", name, flush=True)
    for name in sorted(before - now):
        print("-", name, flush=True)
    before = now
