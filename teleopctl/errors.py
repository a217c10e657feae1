"""The error that every floor raises when a person has to do something about it."""


class TeleopctlError(Exception):
    """A failure with a message for a person and, where there is one, the next thing to do.

    The command line prints ``message`` and ``hint`` to stderr and ends with ``exit_status``;
    a traceback appears only with ``--debug``.

    Args:
        message: What is wrong and where, in one sentence.
        hint: What to do about it, or None.
        exit_status: 1 when the operation failed, 2 when it was asked for wrongly.
    """

    def __init__(self, message: str, *, hint: str | None = None, exit_status: int = 1) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        self.exit_status = exit_status
