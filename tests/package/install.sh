#!/usr/bin/env bash
# Installs the built tree into a folder of its own.
# shellcheck source=tests/package/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

rm -rf "$FEDER_PACKAGE_WORK"
mkdir -p "$FEDER_PACKAGE_WORK"
quietly "$FEDER_CMAKE" --install "$FEDER_TREE" --prefix "$prefix" ${FEDER_CONFIG:+--config "$FEDER_CONFIG"}
for file in include/feder/engine/kkt.h include/feder/solvers/integrators.h include/feder/models/catalog.h \
  share/feder/scenes/README.md share/feder/scenes/mesh_wedge.toml share/feder/scenes/wedge.obj; do
  [[ -f $prefix/$file ]] || fail "$file was not installed"
done
