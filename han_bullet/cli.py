"""The command `han-bullet`: a thin layer of options, tables and exit codes over the library.

Exit codes: 0 done, 1 an expectation failed under --check, 2 bad input, 3 a worker process, a sweep's scheduler
or the ROS node is gone.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich.console import Console

from han_bullet.commands import (
    calibrate,
    detect,
    evaluate,
    explain,
    export,
    report,
    ros_live,
    ros_robot,
    run,
    sweep,
    train,
    worlds,
)
from han_bullet.commands.parsing import Parser
from han_bullet.errors import HanError, WorkerDiedError
from han_bullet.provenance import versions

BAD_INPUT, WORKER_DIED, INTERRUPTED = 2, 3, 130
DESCRIPTION = "Human-aware navigation that sees people: cameras in, considerate robot motion out."


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    complaints = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)
    try:
        options = _parser().parse_args(arguments)
        code: int = options.handler(options, Console())
        return code
    except WorkerDiedError as error:
        complaints.print(f"han-bullet: {error}; files written so far are whole")
        return WORKER_DIED
    except HanError as error:
        complaints.print(f"han-bullet: {error}")
        return BAD_INPUT
    except OSError as error:
        complaints.print(f"han-bullet: {error.filename or 'file'}: {error.strerror or error}")
        return BAD_INPUT
    except KeyboardInterrupt:
        complaints.print("han-bullet: stopped by the keyboard; files written so far are whole")
        return INTERRUPTED


def _parser() -> Parser:
    parser = Parser(prog="han-bullet", description=DESCRIPTION)
    parser.add_argument("--version", action="version", version=f"han-bullet {versions()['han_bullet']}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    for subject in (
        worlds,
        run,
        sweep,
        report,
        explain,
        export,
        detect,
        calibrate,
        evaluate,
        train,
        ros_live,
        ros_robot,
    ):
        subject.add(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
