# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command sundog compare FILE.blend -o DIR`."""

import argparse

import bpy

from . import convergence, job, settings, table

_handles = []


def _parser():
    parser = argparse.ArgumentParser(prog="blender --command sundog", description="Sundog from the command line.")
    commands = parser.add_subparsers(dest="command", required=True)
    compare = commands.add_parser("compare", help="render a frame with Sundog and with Cycles and measure the difference")
    compare.add_argument("file", metavar="FILE.blend")
    compare.add_argument("-o", "--output", metavar="FOLDER", required=True, help="where pictures, difference maps and numbers go")
    compare.add_argument("--samples", type=_count, help="samples a pixel; Sundog's setting in the file if not given")
    compare.add_argument("--frame", type=int, help="the frame; the file's current one if not given")
    compare.add_argument("--percentage", type=_count, help="of the resolution; the file's if not given")
    compare.add_argument("--cycles-defaults", action="store_true", help="leave Cycles as the file has it")
    compare.add_argument(
        "--converge", action="store_true",
        help="instead: render with Cycles at 1, 2, 4 ... samples, for `sundog converge --against FOLDER`",
    )  # fmt: skip
    compare.add_argument("--seeds", type=_count, default=3, help="with --converge: how often, with a seed each")
    return parser


def _count(text):
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError("a number from 1 is needed")
    return value


def execute(arguments):
    """Runs the command; returns the exit code."""
    try:
        given = _parser().parse_args(arguments)
    except SystemExit as error:
        # argparse has said why.
        return error.code or 0
    options = settings.Options(given.samples, given.cycles_defaults, given.percentage, given.frame)
    tell = lambda _fraction, text: print(f"Sundog: {text}", flush=True)  # noqa: E731
    try:
        if given.converge:
            found = convergence.run(given.file, given.output, options, given.seeds, tell)
            print(f"Sundog: measure it with\n{found['command']}", flush=True)
            return 0
        found = job.run(given.file, given.output, options, report=tell)
    except job.CompareError as error:
        print(f"Sundog: {error}", flush=True)
        return 1
    print(table.markdown(found), flush=True)
    return 0


def register():
    """Makes the command known."""
    if hasattr(bpy.utils, "register_cli_command"):
        _handles.append(bpy.utils.register_cli_command("sundog", execute))


def unregister():
    """Takes it away."""
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
