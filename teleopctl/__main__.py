"""The ``teleopctl`` command, also as ``python -m teleopctl``."""

import _signal  # type: ignore[import-not-found] # typeshed leaves private modules out


def main() -> None:
    """Run the command line of this process; until it can say how it ends, Ctrl-C just ends it."""
    # Any import takes a millisecond or more, `signal` too: long enough to be interrupted in.
    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    from teleopctl.cli.main import main as command_line

    command_line()


if __name__ == "__main__":
    main()
