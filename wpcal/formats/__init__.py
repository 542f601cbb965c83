"""Open interchange formats: JSON, CSV, ROS 2, COMPAS, Tesseract."""
