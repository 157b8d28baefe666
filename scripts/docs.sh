#!/usr/bin/env bash
# Installs what is missing and makes the documents: the reference from the headers by Doxygen, the pages by Sphinx.
# They need no network and no server; links within them are checked. With --play the page that runs models stands
# among them (docs/play/index.html): scripts/play.sh makes it, which takes minutes.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: docs.sh [--play] [FOLDER]     default: build/site
set -eu
play=
if [ "${1:-}" = --play ]; then
    play=build/play/index.html
    shift
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
site=${1:-build/site}
bash scripts/install.sh docs
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$site"

if [ -n "$play" ]; then bash scripts/play.sh "$play"; fi
sh docs/site/reference.sh YES "$work"
# Debian's Python has the packages; another one may stand before it in PATH.
python=/usr/bin/python3
[ -x "$python" ] || python=python3
MBSRANK_PLAY=$play MBSRANK_REFERENCE=$work MBSRANK_MATHJAX=/usr/share/javascript/mathjax \
    "$python" -m sphinx -q -W --keep-going -b html -c docs/site -d "$work/trees" . "$site"

# Every link and every file that a page loads is there, and none is elsewhere but links in the text.
"$python" docs/site/check.py "$site"
echo "Pages: $site/index.html"
