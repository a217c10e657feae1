"""Launch actions ``node_container`` and ``load_composable_node``: components in one process."""

from __future__ import annotations

from teleopctl.base.typed import Callable, ClassVar, Iterable, Iterator, Mapping, Self
from teleopctl.errors import NotFoundError
from teleopctl.launch.actions.parameters import parameters
from teleopctl.launch.actions.process import Node
from teleopctl.launch.model.action import Action, Entity, Launch, Step
from teleopctl.launch.model.descriptions import ComponentPart, ParameterEntry
from teleopctl.launch.model.plan import ComponentPlan
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.template import Template, literal
from teleopctl.launch.service_calls import ComponentLoading
from teleopctl.packages import find_component

_LISTS = ("composable_node", "composable_lifecycle_node")
_KEYS = ("pkg", "plugin", "name", "namespace", "param", "remap", "extra_arg")
_RENAMED = {"ns": "namespace", "package": "pkg", "parameters": "param", "remappings": "remap"}


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadComponents(Action):
    """``load_composable_node``: loads components into a container once the container runs.

    Attributes:
        container: Name of the container node.
        components: The components, in order.
    """

    keys = ("target", *_LISTS)
    renamed: ClassVar[Mapping[str, str]] = {"target_container": "target"}

    container: Template
    components: tuple[ComponentPart, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``load_composable_node`` entry describes."""
        components = tuple(_components(entity))
        if not components:
            entity.required_element(_LISTS[0])
        return cls(container=entity.required("target"), components=components)

    def evaluate(self, launch: Launch) -> None:
        """Add to the launch the service calls that load the components whose conditions hold.

        Raises:
            NotFoundError: The container is one of teleopctl's, and a component does not exist.
        """
        name = launch.text(self.container)
        name = name if name.startswith("/") else f"/{name}"
        container = launch.plan_of_node(name)
        is_ours = container is not None and container.loads_components
        plans: list[ComponentPlan] = []
        launch.run(
            tuple(
                Step(part.place, part.conditions, _Planned(part, is_ours, plans.append))
                for part in self.components
            )
        )
        if plans:
            loading = ComponentLoading(name, plans, launch)
            launch.register(loading)
            launch.work(loading)


@dataclass(frozen=True, slots=True)
class _Planned(Action):
    """Action that evaluates one component to a plan."""

    part: ComponentPart
    is_looked_for: bool
    take: Callable[[ComponentPlan], None]

    def evaluate(self, launch: Launch) -> None:
        """Call ``take`` with the component's plan; raise if a checked component does not exist."""
        plan = launch.component(self.part)
        if self.is_looked_for:
            try:
                find_component(plan.package, plan.plugin)
            except NotFoundError as error:
                raise NotFoundError(
                    f"component {plan.plugin} (package {plan.package}) is not here; "
                    "those in C++ cannot be loaded",
                    hint=f"{error.hint} --skip-missing skips it.",
                ) from error
        self.take(plan)


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeContainer(Action):
    """``node_container``: starts a component container and loads components into the container.

    Attributes:
        node: Process of the container.
        components: Components to load into the container, in order.
    """

    keys = (*Node.keys, *_LISTS)
    renamed = Node.renamed

    node: Node
    components: tuple[ComponentPart, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``node_container`` entry describes."""
        entity.required_element("name")
        return cls(node=Node.parse(entity), components=tuple(_components(entity)))

    def evaluate(self, launch: Launch) -> Iterable[Action]:
        """Add the container's process; return a tuple with the action that loads its components."""
        plan = launch.start(self.node)
        assert plan.node_name is not None, "it has a name"
        return (LoadComponents(container=literal(plan.node_name), components=self.components),)


def _components(entity: Entity) -> Iterator[ComponentPart]:
    for key in _LISTS:
        element = entity.element(key)
        if element is None:
            continue
        has_life = key == _LISTS[1]
        for item in element.items("a list of components"):
            keys = (*_KEYS, *(["autostart"] if has_life else []), "if", "unless")
            inner = Entity(item, keys, renamed=_RENAMED)
            yield ComponentPart(
                place=item.place,
                conditions=inner.conditions(),
                package=inner.required("pkg"),
                plugin=inner.required("plugin"),
                name=inner.optional("name"),
                namespace=inner.optional("namespace"),
                parameters=tuple(parameters(inner.element("param"))),
                remaps=inner.pairs("remap", "from", "to"),
                extra_arguments=tuple(
                    ParameterEntry(name, value, None)
                    for name, value in inner.pairs("extra_arg", "name", "value")
                ),
                autostart=inner.optional("autostart") if has_life else None,
            )
