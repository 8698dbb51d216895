# SPDX-License-Identifier: GPL-3.0-or-later
"""The same frame by Sundog and by Cycles, side by side, with numbers.

    sundog.compare.run(None, "/tmp/out", samples=64)        the current scene, from Python
    blender --command sundog compare FILE.blend -o DIR      without a window (Blender 4.2 and later)

    sundog.compare.converge(None, "/tmp/out", seeds=3)      Cycles at 1, 2, 4 … samples, for `sundog converge --against`

and the panel "Compare with Cycles" in the render properties.
"""

from .convergence import run as converge
from .job import CompareError, run
from .settings import Options

__all__ = ("CompareError", "Options", "converge", "run")


def register():
    """Adds the panel, its operators and the command."""
    from . import command, panel

    panel.register()
    command.register()


def unregister():
    """Takes them away."""
    from . import command, panel

    command.unregister()
    panel.unregister()
