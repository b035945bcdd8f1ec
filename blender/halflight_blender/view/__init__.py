# SPDX-License-Identifier: GPL-3.0-or-later
"""What the baked view is made of."""
