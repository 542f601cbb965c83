# SPDX-License-Identifier: MIT
"""The environment in which `wpcal` is started.

FreeCAD as AppImage, Snap or Windows bundle sets variables for its own Python, Qt and libraries. With them, another
Python does not start, or it loads the wrong libraries.
"""

from __future__ import annotations

from typing import Mapping

FREECADS_OWN = (
    "PYTHONHOME",
    "PYTHONPATH",
    "PYTHONSTARTUP",
    "PYTHONNOUSERSITE",
    "PYTHONDONTWRITEBYTECODE",
    "PYTHONEXECUTABLE",
    "__PYVENV_LAUNCHER__",
    "LD_LIBRARY_PATH",
    "LD_PRELOAD",
    "DYLD_LIBRARY_PATH",
    "DYLD_FRAMEWORK_PATH",
    "DYLD_INSERT_LIBRARIES",
    "QT_PLUGIN_PATH",
    "QT_QPA_PLATFORM_PLUGIN_PATH",
    "QT_QPA_PLATFORM",
    "QML2_IMPORT_PATH",
    "GIO_MODULE_DIR",
    "GDK_PIXBUF_MODULE_FILE",
    "FONTCONFIG_FILE",
    "FONTCONFIG_PATH",
    "SSL_CERT_FILE",
    "PATH_TO_FREECAD_LIBDIR",
    "COIN_GL_NO_CURRENT_CONTEXT_CHECK",
)
"""Variables that FreeCAD's bundles set for themselves."""
FREECADS_PREFIXES = ("CSF_", "CASROOT", "APPIMAGE", "APPDIR", "CONDA_")
"""Variables of FreeCAD's CAD kernel and of its bundle begin with these."""
SAVED = ("_ORIG", "_BEFORE_APPIMAGE")  #: Some bundles keep what the user had in a variable with one of these endings.


def clean_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without what belongs to FreeCAD; what a bundle saved of the user's own is put back."""
    clean = {
        name: value
        for name, value in environment.items()
        if name not in FREECADS_OWN and not name.startswith(FREECADS_PREFIXES) and not name.endswith(SAVED)
    }
    for name in FREECADS_OWN:
        for ending in SAVED:
            if environment.get(name + ending):
                clean[name] = environment[name + ending]
    clean["PYTHONUTF8"] = "1"  # names of parts pass as UTF-8 on Windows too
    return clean
