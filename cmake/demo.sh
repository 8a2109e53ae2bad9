#!/bin/sh
# Installs what is missing, builds the command and simulates 100 coupled vehicle suspensions for 5 s.
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh

install_packages ""
if [ -f build/release/CMakeCache.txt ]; then
    cmake --preset release
else
    cmake --preset release -DGUDGEON_TESTS=OFF -DGUDGEON_BENCH=OFF
fi
cmake --build --preset release --target gudgeon
mkdir -p results
exec build/release/bin/gudgeon run suspension-chain --param units=100 \
    --channels 'chassis*.z,energy.*' --out results/suspension-chain
