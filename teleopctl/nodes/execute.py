"""Execution of a program in this process, as ``ros2 run`` would start it.

The program may be one of teleopctl's, an installed entry point, a program of a source package that
was never built, or a plain file. The program, and Python programs that it starts, can import
``rclpy`` and message packages.
"""

import errno
import gc
import importlib
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

from teleopctl.base import interrupts, progress
from teleopctl.base.extras import missing_module_hint
from teleopctl.errors import EXIT_INTERRUPTED, NotFoundError, SystemFailureError, TeleopctlError
from teleopctl.packages import PackageProgram, apply_source_hooks, find_executable

_PACKAGE = __name__.partition(".")[0]
_FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "")  # noqa: PTH100, PTH118, PTH120


def run_executable(
    package: str | None, executable: str, args: Sequence[str], *, builtin: bool = False
) -> int:
    """Find an executable of a package or by path, run it in this process; return the exit status.

    Args:
        package: Package of the program; None when ``executable`` is a path or a unique name.
        executable: Name of the program, or path of a file.
        args: Arguments of the program, including ``--ros-args``; passed on unchanged.
        builtin: Whether only packages of teleopctl itself are searched.

    Returns:
        Exit status: the program's return value, 130 when Ctrl-C ended the program, 0 when its
        context was shut down from outside, 1 after an exception, whose traceback has been printed.

    Raises:
        TeleopctlError: The program does not exist, or a program of teleopctl raised the error. From
            a user's code, the error is handled like any other exception.
        SystemExit: The program called ``sys.exit``.
    """
    return execute(find_executable(package, executable, builtin=builtin), args)


def preload(package: str, executable: str) -> None:
    """Import the modules of a program of teleopctl, by its module's function ``preload``.

    Raises:
        TeleopctlError: The program does not exist.
    """
    _limit_threads()
    target = find_executable(package, executable, builtin=True).target
    importlib.import_module(target.partition(":")[0]).preload()


def execute(executable: PackageProgram, args: Sequence[str]) -> int:
    """Run a program that `find_executable` found, in this process; return its exit status."""
    from teleopctl.base.output import discard_output, outlive_output, take_log_file
    from teleopctl.compat import activation

    log_file = take_log_file()
    # In the foreground, the output may be a result that the user sends to a pipe or a file.
    outlive_output(log_file=log_file, lossless_stdout=log_file is None)
    activation.activate()
    activation.activate_children()
    if executable.package and not _is_of_teleopctl(executable):
        apply_source_hooks()
    if executable.import_roots:
        roots = [str(root) for root in executable.import_roots]
        sys.path[:0] = roots
        # Child processes of the program have to find the package as well.
        inherited = os.environ.get("PYTHONPATH")
        os.environ["PYTHONPATH"] = os.pathsep.join(roots + ([inherited] if inherited else []))
    try:
        if executable.file is not None:
            return _run_file(executable.file, args)
        return _call(executable, args)
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except Exception as error:
        if interrupts.is_cause(error):
            return EXIT_INTERRUPTED
        if _is_external_shutdown(error):
            return 0
        if isinstance(error, BrokenPipeError) and not _is_from_user_code(error, executable):
            discard_output()  # the reader, such as ``head``, has closed the pipe
            return 0
        if isinstance(error, TeleopctlError) and not _is_from_user_code(error, executable):
            raise
        _print_traceback(error)
        return 1


def _call(executable: PackageProgram, args: Sequence[str]) -> int:
    module_name, _, function_name = executable.target.partition(":")
    sys.argv = [executable.name, *args]
    if _is_of_teleopctl(executable):
        _limit_threads()
    else:
        _collect_garbage()
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name != module_name:
            raise
        raise NotFoundError(
            f"Executable '{executable.name}' of package '{executable.package}' names the module "
            f"{module_name}, which does not exist"
        ) from error
    if module.__file__:
        sys.argv[0] = module.__file__
    function = module
    for part in function_name.split("."):
        function = getattr(function, part, None)  # type: ignore[assignment]
    if not callable(function):
        raise NotFoundError(
            f"Executable '{executable.name}' of package '{executable.package}' names "
            f"{executable.target}, which is not a function"
        )
    _collect_garbage()
    return _status(function())


def _collect_garbage() -> None:
    """Begin to look for garbage, which `teleopctl.nodes.__main__` puts off, but not in modules."""
    if not gc.isenabled():
        gc.freeze()
        gc.enable()


def _limit_threads() -> None:
    # Our nodes multiply small matrices only. Importing numpy costs 40 ms of processor time more
    # with OpenBLAS's threads, which spin until there is work.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _run_file(file: Path, args: Sequence[str]) -> int:
    _collect_garbage()
    if file.suffix != ".py" and not _is_python(file):
        return _run_program(file, args)
    import runpy

    sys.argv = [str(file), *args]
    runpy.run_path(str(file), run_name="__main__")
    return 0


def _is_python(file: Path) -> bool:
    with file.open("rb") as stream:
        first_line = stream.readline(200)
    return first_line.startswith(b"#!") and b"python" in first_line


def _use_of(file: Path) -> str:
    if file.suffix in (".urdf", ".xacro"):
        return f"It describes a robot: `teleopctl launch display.yaml model:={file}` shows it."
    if file.suffix in (".yaml", ".yml"):
        return f"If it is a launch file: teleopctl launch {file}"
    return f"If it is one, it may not be run, or its first line (#!) is missing: chmod +x {file}"


def _run_program(file: Path, args: Sequence[str]) -> int:
    """Run a program that is not Python; pass SIGINT and SIGTERM on to it."""
    import subprocess

    progress.report_session(progress.ANY_SESSION)
    try:
        # SIGPIPE stays ignored, as in Python: printing to a closed pipe must not end a node.
        process = subprocess.Popen([str(file), *args], restore_signals=False)
    except OSError as error:
        if error.errno in (errno.EACCES, errno.ENOEXEC):
            raise SystemFailureError(f"{file} is no program", hint=_use_of(file)) from error
        raise SystemFailureError(f"Cannot run {file}: {error.strerror}") from error
    signal.signal(signal.SIGINT, lambda number, _: process.send_signal(number))
    signal.signal(signal.SIGTERM, lambda number, _: process.send_signal(number))
    status = process.wait()
    return status if status >= 0 else 128 - status


def _status(returned: object) -> int:
    """Turn what ``main`` returned into an exit status, by the rules of ``sys.exit``."""
    if returned is None:
        return 0
    if isinstance(returned, int):
        return int(returned)
    sys.stderr.write(f"{returned}\n")
    return 1


def _is_external_shutdown(error: Exception) -> bool:
    # A program without nodes never imports the module of this class.
    module = sys.modules.get("teleopctl.node.values.exceptions")
    expected = getattr(module, "ExternalShutdownException", None)
    return expected is not None and isinstance(error, expected)


def _is_of_teleopctl(executable: PackageProgram) -> bool:
    return executable.target.startswith(f"{_PACKAGE}.")


def _is_from_user_code(error: BaseException, executable: PackageProgram) -> bool:
    if _is_of_teleopctl(executable):
        return False
    trace = error.__traceback__
    while trace is not None:
        if not _is_ours(trace.tb_frame.f_code.co_filename):
            return True
        trace = trace.tb_next
    return False


def _print_traceback(error: BaseException) -> None:
    """Print a traceback of the program without the frames of teleopctl.

    Frames of teleopctl after the user's last frame stay, unless the error is a `TeleopctlError`.
    """
    import traceback

    errors = [traceback.TracebackException.from_exception(error)]
    for each in errors:
        frames = [f for f in each.stack if not _starts_programs(f.filename)]
        of_user = [i for i, frame in enumerate(frames) if not _is_ours(frame.filename)]
        if of_user:
            foreseen = each.exc_type is not None and issubclass(each.exc_type, TeleopctlError)
            behind = [] if foreseen else frames[of_user[-1] + 1 :]
            frames = [*(frames[i] for i in of_user), *behind]
        each.stack[:] = frames
        errors.extend(other for other in (each.__cause__, each.__context__) if other is not None)
        errors.extend(each.exceptions or ())
    sys.stderr.write("".join(errors[0].format()))
    hint = error.hint if isinstance(error, TeleopctlError) else missing_module_hint(error)
    if hint:
        sys.stderr.write(f"{hint}\n")


def _is_ours(filename: str) -> bool:
    return filename.startswith(_FOLDER) or _starts_programs(filename)


def _starts_programs(filename: str) -> bool:
    return filename in (__file__, importlib.__file__) or filename.startswith("<frozen ")
