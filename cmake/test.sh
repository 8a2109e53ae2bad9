#!/bin/sh
# Installs what is missing and runs every check: format, tests in release, those of the solvers that
# GPL parts of SuiteSparse replace, a program that uses the installed package, and all tests but the
# slow ones under the sanitizers.
# The last line is "N passed, N failed"; the exit status is 0 only when nothing failed.
set -u
cd "$(dirname "$0")/.." || exit 1
. cmake/packages.sh

passed=0
failed=0
jobs=$(nproc)
speed=build/release/bench/regression/gudgeon_regression-counts/report.txt
export OMP_WAIT_POLICY=passive # tests run side by side
unset GUDGEON_QUICK

# check NAME COMMAND...: one check more, passed or failed.
check() {
    name=$1
    shift
    echo "== $name"
    if "$@"; then
        passed=$((passed + 1))
    else
        echo "FAILED: $name"
        failed=$((failed + 1))
        return 1
    fi
}

# tests DIRECTORY OPTION...: runs ctest there and adds its counts.
tests() {
    directory=$1
    shift
    echo "== tests in $directory"
    log=$directory/tests.log
    timeout 1800 ctest --test-dir "$directory" -j "$jobs" --output-on-failure "$@" >"$log" 2>&1 </dev/null
    grep -vE '^ +Start +[0-9]+:|^ *[0-9]+/[0-9]+ Test .* Passed ' "$log"
    counts=$(sed -n 's/^[0-9]*% tests passed, \([0-9]*\) tests* failed out of \([0-9]*\)$/\1 \2/p' "$log")
    if [ -z "$counts" ] || [ "$counts" = "0 0" ]; then
        echo "FAILED: no complete test run in $directory"
        failed=$((failed + 1))
        return 1
    fi
    skipped=$(grep -c '\*\*\*Skipped' "$log")
    failed=$((failed + ${counts% *}))
    passed=$((passed + ${counts#* } - ${counts% *} - skipped))
}

formatted() {
    find app bench contact core models solvers tests -name '*.[ch]pp' -print0 |
        xargs -0 -r clang-format --dry-run -Werror
}

build() {
    cmake --preset "$1" -DGUDGEON_TESTS=ON && cmake --build --preset "$1" -j "$jobs"
}

package() {
    rm -rf build/prefix build/external
    cmake --install build/release --prefix build/prefix >/dev/null &&
        cmake -S tests/external -B build/external -G Ninja -DCMAKE_BUILD_TYPE=Release \
            -DCMAKE_PREFIX_PATH="$PWD/build/prefix" &&
        cmake --build build/external -j "$jobs"
}

if check "packages" install_packages test; then
    check "clang-format" formatted
    if check "build release" build release; then
        rm -f "$speed"
        tests build/release --timeout 600
        [ ! -f "$speed" ] || { echo "== speed against the record (bench/regression)" && cat "$speed"; }
        check "build with the GPL parts of SuiteSparse" build gpl &&
            tests build/gpl --timeout 300 -R '^(Rank|NormalSolver)'
        check "build a program with the installed package" package && tests build/external --timeout 120
    fi
    check "build with sanitizers" build asan &&
        GUDGEON_QUICK=1 tests build/asan --timeout 300 -E Slow
fi

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
