# SPDX-License-Identifier: MIT
"""What a document keeps: seams, taught points and calibration, and the session with wpcal that belongs to it."""
