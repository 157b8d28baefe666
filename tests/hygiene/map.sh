#!/bin/sh
# docs/architecture.svg is what scripts/map.sh draws of the table of rooms.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: map.sh PROJECT_DIR
set -eu
sh "$1/scripts/map.sh" | cmp - "$1/docs/architecture.svg" || { echo "run scripts/map.sh >docs/architecture.svg"; exit 1; }
