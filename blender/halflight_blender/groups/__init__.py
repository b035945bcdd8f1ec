# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups of the last bake: their sliders, the lamps and materials that follow these, and keyframes."""
