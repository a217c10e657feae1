"""Service with which a controller's changed code takes over."""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING, Any

from teleopctl import plugins
from teleopctl.base.exception_origin import with_origin
from teleopctl.control.controller_manager import ControllerManager
from teleopctl.control.reloading.controller_reload import (
    ControllerReload,
    ReloadError,
    ReloadRefusedError,
)
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_service, to_nanoseconds
from teleopctl.node import Future

if TYPE_CHECKING:
    from teleopctl.node import Node

SERVICE_TYPE = "teleopctl_msgs/srv/ReloadController"
# Longest import, initialization and configuration of new code by default, in seconds.
TIMEOUT_S = 10.0
# Longest wait for the first update before the response; no update comes during a pause.
FIRST_UPDATE_WITHIN_S = 2.0


class ReloadService:
    """Service ``~/reload_controller`` of a controller manager, for one reload at a time.

    While the new code is prepared, on a thread of its own, other services and the subscriptions of
    controllers are served.

    Args:
        node: Node of the controller manager.
        manager: Controller manager with the controllers.
    """

    def __init__(self, node: Node, manager: ControllerManager) -> None:
        self._node = node
        self._manager = manager
        self._reloading: str | None = None
        # Reloads whose first update is still to come.
        self._pending: dict[str, ControllerReload] = {}
        self._service = node.create_service(
            get_service(SERVICE_TYPE), "~/reload_controller", self._reload
        )

    # Any: message classes are generated at run time.
    async def _reload(self, request: Any, response: Any) -> Any:
        name, manager = request.name, self._manager
        timeout_s = to_nanoseconds(request.timeout) / NANOSECONDS_PER_SECOND
        broken: list[str] = []
        try:
            words = await self._reload_within(name, timeout_s if timeout_s > 0 else TIMEOUT_S)
        except Exception as error:  # noqa: BLE001 - a failure must not end the manager
            response.message = self._report(name, error)
            if isinstance(error, ReloadError) and error.file is not None:
                broken.append(error.file)
        else:
            response.ok = True
            response.message = f"Successfully reloaded controller {name}: {words}"
            manager.logger.info(response.message)
        if (spec := manager.controllers.get(name)) is not None:
            files = plugins.source_files(plugins.CONTROLLERS, spec.type)
            response.files = sorted({*files, *broken})
        return response

    def _report(self, name: str, error: Exception) -> str:
        goes_on = "" if isinstance(error, ReloadRefusedError) else ", its running code goes on"
        reason = error if isinstance(error, ReloadError) else with_origin(error)
        message = f"Could not reload controller '{name}'{goes_on}: {reason}"
        self._manager.logger.error(message)
        return message

    async def _reload_within(self, name: str, timeout_s: float) -> str:
        if self._reloading is not None:
            raise ReloadRefusedError(f"controller '{self._reloading}' is being reloaded")
        if (pending := self._pending.pop(name, None)) is not None:
            pending.withdraw()
            with contextlib.suppress(ReloadError):
                pending.finish()
        reload = ControllerReload(self._manager, name)
        self._reloading = name
        try:
            await self._prepare(reload, timeout_s)
            decided = Future[None](executor=self._node.executor)
            reload.on_settled = lambda: decided.set_result(None)
            reload.commit()
            await _within(decided, FIRST_UPDATE_WITHIN_S)
            if reload.is_settled.is_set():
                return reload.finish()
        finally:
            self._reloading = None
        assert self._node.executor is not None
        self._pending[name] = reload
        self._node.executor.create_task(self._finish_later, reload)
        return "its first update comes with the next control cycle"

    async def _prepare(self, reload: ControllerReload, timeout_s: float) -> None:
        prepared = Future[None](executor=self._node.executor)
        failures: list[Exception] = []

        def prepare() -> None:
            try:
                reload.prepare()
            except Exception as error:  # noqa: BLE001 - raised in the service's callback
                failures.append(error)
            finally:
                prepared.set_result(None)

        threading.Thread(target=prepare, name=f"reload {reload.name}", daemon=True).start()
        await _within(prepared, timeout_s)
        if failures:
            raise failures[0]
        if (phase := reload.abandon()) is not None:
            raise ReloadError(f"after {timeout_s:g} s, {phase}")

    async def _finish_later(self, reload: ControllerReload) -> None:
        """Release the unused instance once cycles run again, for example after a pause."""
        decided = Future[None](executor=self._node.executor)
        reload.on_settled = lambda: decided.set_result(None)
        if not reload.is_settled.is_set():
            await decided
        if self._pending.get(reload.name) is not reload:
            return
        del self._pending[reload.name]
        try:
            reload.finish()
        except Exception as error:  # noqa: BLE001 - as above
            self._report(reload.name, error)


async def _within(future: Future[None], seconds: float) -> None:
    """Wait for a future, which is ended after some seconds of wall time."""
    timer = threading.Timer(seconds, future.set_result, (None,))
    timer.daemon = True
    timer.start()
    await future
    timer.cancel()
