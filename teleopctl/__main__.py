"""``python -m teleopctl`` is the ``teleopctl`` command."""

from teleopctl.cli.main import main

main()
