# SPDX-License-Identifier: GPL-3.0-or-later
"""The program that comes inside the packaged add-on: bin/sundog, its libraries beside it in lib/."""

import os
import stat

FOLDER = os.path.dirname(os.path.abspath(__file__))


def program():
    """The path of the bundled program, ready to be run, or None if the add-on was not packaged with one.

    Blender unpacks extensions with `zipfile.extract`, which keeps no permissions: the program has to be made executable
    again. Where that is not allowed (a repository of the system), the error is the operating system's when it is started.
    """
    path = os.path.join(FOLDER, "bin", "sundog")
    if not os.path.isfile(path):
        return None
    if not os.access(path, os.X_OK):
        try:
            os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
        except OSError:
            pass
    return path
