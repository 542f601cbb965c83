"""Robot controllers: programs written for them, and taught points read from theirs; one folder per brand."""

from wpcal.controllers.registry import Controller, controller_named, controller_names, controllers

__all__ = ["Controller", "controller_named", "controller_names", "controllers"]
