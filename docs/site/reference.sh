#!/bin/sh
# Runs Doxygen over the public headers; fails with its warnings. Fields and constants whose names say what they are
# need no comment of their own.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: reference.sh YES|NO FOLDER     NO: warnings alone, no pages
set -eu
cd "$(dirname "$0")/../.."
export REFERENCE_HTML="$1" REFERENCE_OUTPUT="$2" REFERENCE_TAGS="$2/reference.tag" REFERENCE_WARNINGS="$2/warnings"
doxygen docs/site/Doxyfile >/dev/null
if grep -vE '\((variable|macro definition|enumeration value)\).* is not documented' "$2/warnings"; then exit 1; fi
