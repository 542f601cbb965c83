"""Open interchange formats: JSON, CSV, ROS 2, COMPAS, Tesseract; and the list of all formats that can be written."""

from wpcal.controllers.registry import Exporter, exporter_named, exporter_names

__all__ = ["Exporter", "exporter_named", "exporter_names"]
