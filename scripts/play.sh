#!/usr/bin/env bash
# Makes the page that runs models, in one file that needs no network: the library in WebAssembly (scripts/wasm.sh), the
# viewer bundled by npm, and the models of examples/models to choose from.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: play.sh [PAGE] [SOURCES]     PAGE: default build/play/index.html; SOURCES: as of wasm.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
page=${1:-build/play/index.html}
mkdir -p "$(dirname "$page")" build/play
page=$(cd "$(dirname "$page")" && pwd)/$(basename "$page")
bash scripts/install.sh page web
bash scripts/wasm.sh build/play/wasm ${2:+"$2"}
examples=("$PWD"/examples/models/{arm.urdf,*.xml,*.sdf})
cmake -DSOURCE="$PWD/src/program/viewer" -DWORK="$PWD/build/play/viewer" -DOUT="$page" -DNPM=npm -DNODE=node -DREQUIRED=ON \
    -DLIVE="$PWD/build/play/wasm/package;$(IFS=';' && echo "${examples[*]}")" -P cmake/MbsrViewer.cmake
echo "$page: $(stat -c %s "$page") bytes"
