"""Node with a publisher, a subscription and a service of types that only its process can find."""

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Node, init, spin

init()
node = Node("stranger")
goals = get_message("strange_msgs/msg/Goals")
publisher = node.create_publisher(goals, "/goals", 10)
message = goals(names=["here", "there"])
message.where.x = 2.5
node.create_timer(0.05, lambda: publisher.publish(message))
node.create_subscription(
    goals, "/wishes", lambda heard: print("wished for", *heard.names, flush=True), 10
)


def pick(request, response):
    response.number = len(request.goals.names)
    return response


node.create_service(get_service("strange_msgs/srv/Pick"), "/pick", pick)
print("up", flush=True)
spin(node)
