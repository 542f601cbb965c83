# SPDX-License-Identifier: MIT
"""What the workbench draws in the 3-D view. Needs a window."""
