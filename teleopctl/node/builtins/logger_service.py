"""The services that read and set the levels of a process's loggers."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import get_message, get_service
from teleopctl.node.values import logging

if TYPE_CHECKING:
    from teleopctl.node.node_endpoints import NodeEndpoints


class LoggerService:
    """Services ``~/get_logger_levels`` and ``~/set_logger_levels`` of a node."""

    def __init__(self, node: NodeEndpoints) -> None:
        node.create_service(
            get_service("rcl_interfaces/srv/GetLoggerLevels"), "~/get_logger_levels", self._get
        )
        node.create_service(
            get_service("rcl_interfaces/srv/SetLoggerLevels"), "~/set_logger_levels", self._set
        )

    @staticmethod
    def _get(request: Any, response: Any) -> Any:
        level = get_message("rcl_interfaces/msg/LoggerLevel")
        response.levels = [
            level(name=name, level=int(logging.get_logger_level(name))) for name in request.names
        ]
        return response

    @staticmethod
    def _set(request: Any, response: Any) -> Any:
        outcome = get_message("rcl_interfaces/msg/SetLoggerLevelsResult")
        results = []
        for wanted in request.levels:
            try:
                logging.set_logger_level(wanted.name, wanted.level)
            except ValueError:
                results.append(
                    outcome(successful=False, reason="Failed reason: Invalid logger level.")
                )
            else:
                results.append(outcome(successful=True))
        response.results = results
        return response
