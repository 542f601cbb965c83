# SPDX-License-Identifier: MIT
"""The task panels. Need a window."""
