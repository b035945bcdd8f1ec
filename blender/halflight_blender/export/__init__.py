# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as the program reads it."""
