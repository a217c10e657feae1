"""Files that clients may fetch: meshes and textures of robot descriptions."""

from __future__ import annotations

from urllib.parse import unquote

from teleopctl.errors import SystemFailureError, TeleopctlError
from teleopctl.node import RcutilsLogger
from teleopctl.nodes.foxglove_bridge.settings import BridgeSettings, allows
from teleopctl.packages import resolve_uri


class Assets:
    """Reads the files of asset URIs, on the server's threads.

    Args:
        settings: Which URIs clients may ask for.
        logger: Told of what was refused or is missing.
    """

    def __init__(self, settings: BridgeSettings, logger: RcutilsLogger) -> None:
        self._settings = settings
        self._logger = logger

    def __call__(self, uri: str) -> bytes | None:
        """The bytes of a file; None where there is none for clients."""
        # Two dots would lead out of the package, also where they are written as %2e%2e.
        if ".." in unquote(uri) or not allows(self._settings.assets, uri):
            self._logger.warning(f"Asset URI not allowed: {uri}")
            return None
        try:
            return resolve_uri(uri).read_bytes()
        except OSError as error:
            failure: TeleopctlError = SystemFailureError(error.strerror or str(error))
        except TeleopctlError as error:
            failure = error
        self._logger.warning(f"Failed to retrieve asset '{uri}': {failure.message}")
        return None
