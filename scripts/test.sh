#!/usr/bin/env bash
# Installs what is missing, then builds and tests libmbsrank in three ways, in build trees below
# build/, the second and third beside the first: gcc Release, clang Debug with address and undefined-behaviour sanitizers, core alone (clang
# Release, static, without LAPACK and vector code). Warnings are errors in all of them; sources are compiled several at once, and
# gcc reads each alone, too. The numerical tests of
# the first run with the other LAPACK too, those that call it. What the first build tests in full, but for the seeds of the
# longest tests, the others test with fewer random trees and without the longest runs; the second and third leave out
# what reaches no code of its own there. Where no compiler has sanitizers there is a clang Debug build in their place.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: test.sh [--long]
#     --long    all seeds and whole runs in every build (tests/support/duration.h), and clang Debug
#               without sanitizers; hours
set -eu
long=OFF
for option; do
    case $option in
    --long) long=ON ;;
    *) echo "usage: test.sh [--long]" >&2; exit 2 ;;
    esac
done
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash scripts/install.sh build test

jobs=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
generator="Unix Makefiles"
if command -v ninja >/dev/null; then generator=Ninja; fi
rm -rf build/test-results
mkdir -p build/test-results

# What no compiler has a part in is tested once.
once='hygiene\.(columns|finite|forbidden_calls|format|function_length|links|map|names|paths|records|reference|references|rooms|root|sentences|snippets|tables|validation|versions)'

# says PLACE NAME TEXT; fails PLACE NAME: lines of the summary, by their places in it; what has failed.
says() { echo "$2: $3" >>"build/test-results/$1.line"; }
fails() { echo "$2" >>"build/test-results/$1.failed"; }

# run PLACE NAME COMPILER OPTIONS -- CTEST_OPTIONS: configures, builds and tests in build/test-NAME.
run() {
    local place=$1 name=$2 compiler=$3 tree=build/test-$2
    shift 3
    local options=()
    while [ "$1" != -- ]; do options+=("$1"); shift; done
    shift
    echo "==== $name ($compiler)"
    mkdir -p "$tree"
    times >"$tree/times"
    if cmake -S . -B "$tree" -G "$generator" -DCMAKE_C_COMPILER="$compiler" -DMBSR_WERROR=ON \
            -DMBSR_TEST_LONG="$long" "${options[@]}" >"$tree/configure.log" 2>&1; then
        :
    else
        cat "$tree/configure.log"
        fails "$place" "$name"
        says "$place" "$name" "does not configure"
        return
    fi
    times >>"$tree/times"
    if ! cmake --build "$tree" --parallel "$jobs" >"$tree/build.log" 2>&1; then
        cat "$tree/build.log"
        fails "$place" "$name"
        says "$place" "$name" "does not build"
        return
    fi
    times >>"$tree/times"
    (cd "$tree" && ctest --output-on-failure --no-tests=error --parallel "$jobs" "$@") |
        tee "$tree/ctest.log" || fails "$place" "$name"
    times >>"$tree/times"
    says "$place" "$name" "$(grep -E '^[0-9]+% tests passed' "$tree/ctest.log" || echo 'no tests')"
    # every second line is of processes that have ended: user, system
    says "$place" "$name" "$(awk -F'[ms ]+' 'NR % 2 == 0 { t[NR / 2] = 60 * ($1 + $3) + $2 + $4 }
        END { printf "%.0f + %.0f + %.0f processor seconds: configuration, build, tests", t[2] - t[1], t[3] - t[2], t[4] - t[3] }' \
        "$tree/times")"
}

# works COMPILER: whether it can build and run a program with the sanitizers.
works() {
    local folder result=0
    command -v "$1" >/dev/null || return 1
    folder=$(mktemp -d)
    echo 'int main(void) { return 0; }' >"$folder/a.c"
    "$1" -fsanitize=address,undefined -o "$folder/a" "$folder/a.c" 2>/dev/null &&
        "$folder/a" 2>/dev/null || result=1
    rm -rf "$folder"
    return $result
}

# The numerical tests of gcc-release again, with each LAPACK of lapack.sh that is not the default.
other_lapacks() {
    local tree=build/test-gcc-release name status
    for name in reference openblas; do
        status=0
        bash scripts/lapack.sh "$name" --for "$tree/tests/property_tests" || status=$?
        if [ "$status" -eq 1 ]; then continue; fi
        if [ "$status" -ne 0 ]; then
            echo "==== LAPACK $name: left out, not found"
            continue
        fi
        echo "==== LAPACK $name"
        MBSR_TEST_FEW=1 bash scripts/lapack.sh "$name" ctest --test-dir "$tree" \
            --output-on-failure --no-tests=error --parallel "$jobs" -R "^($by_lapack)\$" |
            tee "$tree/ctest-$name.log" || fails 2 "LAPACK $name"
        says 2 "LAPACK $name" \
            "$(grep -E '^[0-9]+% tests passed' "$tree/ctest-$name.log" || echo 'no tests')"
    done
}

# Code of sanitizers is large: lld links it in a third of the time.
linker=()
if command -v ld.lld >/dev/null; then linker=(-DCMAKE_{EXE,SHARED,MODULE}_LINKER_FLAGS=-fuse-ld=lld); fi

set -o pipefail
# Threads of a BLAS that wait for work take the other test's core.
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
# tests/support/duration.h; without it ctest takes more seeds
if [ "$long" = OFF ]; then export MBSR_TEST_SHORT=1; fi
gcc=gcc
if ! command -v gcc >/dev/null; then gcc=cc; fi
# The fewest tests that reach every arc of the functions that call LAPACK, those whose results its numbers decide, and all
# models with printed numbers; in runs too little is asked of it.
by_lapack='(reference|linear)\..*|property\.(flexible_chains|loops_medley|loops_mobility|newton_loops|newton_medley)|unit\.(any_bytes|assembly|axes|beam|callers_fail|completion|compliance|far_starts|flex.*|inertia|inertia_unchecked|joint_check|kept_rates|kinematics|lapack|model|newton|newton_loops|newton_singular|no_allocation|null_.*|ode.*|parameters|rank_.*|results|springs|start|stiffening|units)'
long_tests="$once|ida\.(bead|beam|beam_in_space|car_axis|linear|mechanisms|small_car_axis|small_masses|small_models|small_trees|space|springs|stiff|stiff_cells)|unit\.(finite_solvers|stepper_order|stepper_real_time)|property\.newton|example\.(12_elastic_support|14_cable|18_sdirk|31_doubtful_masses|32_flexible_arm|35_flexible_rod|37_real_time|demo_tree)"
no_packages=(-E '^package\.(core_shared|core_static|ida_static)$') # the minimal build tests core_static
# names LABEL NAME...: these tests, without a group, of which CMake allows ten in an expression.
names() {
    local label=$1
    shift
    printf "|$label\\\\.%s" "$@"
}
# What reaches no code under sanitizers that the others do not, but a fiftieth of the arcs of gcov.
repeated='program\.(documents|fit)'
repeated+=$(names contact contact_motion contact_ragdoll contact_round contact_slopes)
repeated+=$(names files robots)
repeated+=$(names linear four_bar linear_bicycle linear_small)
repeated+=$(names ida cuts driver flexible grid groups index1 jumps kinked_forces kinks loops loops_elastic loops_more massless \
    friction moving_starts networks no_start norms outputs paper rank_watch rounding small_swings stability static_modes stiff_pins stiffening tolerances units)
repeated+=$(names unit changed_fields far_starts finite_forms finite_stepper fronts index1 joint_tangents joint_twins loops_tree_start \
    newton_flexible newton_loop_joints newton_loops newton_follower ode_undetermined parallel plane refined slender survey sweeps \
    bounded dense flexible_frames forces_space frames gear_of_one_body groups inertia_space inertia_unchecked joints lapack \
    loops_units momentum_loops momentum_scales newton_loops_mixed null_vectors rank_bound rank_pivots rigid settled small_cost \
    start_bytes stiff_inverse batch_aligned momentum null_space places_left report_cost)
repeated+=$(names property cut_anywhere flexible_chains flexible_models fresh_data kept_rates loops_invariance loops_mobility loops_motors loops_ranks newton_loops \
    random_loops random_trees space space_equivalence stepper_medley turned_trees verdicts)
repeated+=$(names reference index_added index_joints index_loops index_models index_points index_report paper_equations tree_files validation)
repeated+=$(names example 01_upper_configuration 02_lower_configuration 03_oscillators 04_own_integrator 05_user_joint \
    06_caller_memory 07_explicit 08_cvode 09_rank_change 11_gimballed_rotor 19_engine 23_events 24_index_report 25_own_force \
    30_robot_arm 38_fmu 10_quarter_car 13_universal_joint 15_flyball_governor 16_heavy_top 17_bouncing_ball \
    20_double_wishbone 21_sampled_control 22_road 27_options 29_drive_train 33_squeezer 34_spin_up_beam 36_fe_plate 40_quadruped \
    demo_oscillators)
if [ "$long" = ON ]; then repeated=none by_lapack='(unit|reference|property|ida|linear)\..*' long_tests=$once no_packages=(); fi
# The module of WebAssembly, unoptimised but in the long run, where its packages and sources can be had.
first() {
    local web=()
    mkdir -p build/test-web
    if bash scripts/install.sh web >build/test-web/install.log 2>&1 &&
            bash scripts/wasm.sh --fetch build/test-web >>build/test-web/install.log 2>&1; then
        web=(-DMBSR_WEB=ON -DMBSR_WEB_SOURCES="$PWD/build/test-web" -DMBSR_WEB_BUILD=Debug)
        if [ "$long" = ON ]; then web+=(-DMBSR_WEB_BUILD=MinSizeRel); fi
    else
        echo "==== web: left out, its packages or sources cannot be had"
    fi
    # with checks of buffers' sizes, as distributions compile
    run 1 gcc-release "$gcc" -DCMAKE_BUILD_TYPE=Release "-DCMAKE_C_FLAGS=-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2" -DMBSR_BENCH=ON -DMBSR_UNITY=CHECKED \
        "${linker[@]}" "${web[@]}" -- "${no_packages[@]}"
    other_lapacks
}

# The others, beside the first: they take what it leaves of the processors.
others() {
    local sanitizer= compiler minimal=clang only less headers='' trap=()
    renice -n 10 "$BASHPID" >/dev/null 2>&1 || true
    for compiler in clang "$gcc"; do
        if [ -z "$sanitizer" ] && works "$compiler"; then sanitizer=$compiler; fi
    done
    if [ -n "$sanitizer" ]; then
        # a trap with its place in the source instead of a text: less code, and a tenth of what the loader relocates
        if [ "$sanitizer" = clang ] && [ "$long" = OFF ]; then trap=(-DCMAKE_C_FLAGS=-fsanitize-trap=undefined); fi
        # of what was freed 8 MB wait, of where 6 calls are kept: pages and stacks of more are a tenth of the tests; C++ is the first's
        ASAN_OPTIONS=handle_sigill=1:quarantine_size_mb=8:malloc_context_size=6 \
            run 3 sanitizers "$sanitizer" -DCMAKE_BUILD_TYPE=Debug -DMBSR_VIEWER=OFF -DMBSR_CXX=none \
            -DMBSR_UNITY=ON -DCMAKE_C_FLAGS_DEBUG=-g1 "${linker[@]}" "${trap[@]}" -DMBSR_SANITIZE=address,undefined -DMBSR_TEST_WITHOUT="$long_tests|$repeated" -- -E "^($long_tests|$repeated)\$"
    else
        echo "==== sanitizers: left out, no compiler has them"
    fi
    if command -v clang >/dev/null; then
        if [ -z "$sanitizer" ] || [ "$long" = ON ]; then
            run 4 clang-debug clang -DCMAKE_BUILD_TYPE=Debug -DMBSR_BENCH=ON -DMBSR_VIEWER=OFF -- -LE package
        fi
    else
        echo "==== clang: left out, not found"
        minimal=$gcc
    fi
    # by clang, without LAPACK, vector code and what needs IDA; the tests that what is left out may change
    only='(reference|property|fe|program|hygiene|example)\..*|files\.pictures|package\.core_static|unit\.(any_bytes|blocks|completion|dense|finite.*|jacobi|lapack|no_allocation|own_lapack|parallel|start.*|threads)'
    # -O1 without -O3 for what loops (src/CMakeLists.txt): a third less to compile, tests as fast
    less=(-DCMAKE_BUILD_TYPE=MinSizeRel "-DCMAKE_C_FLAGS_MINSIZEREL=-O1 -DNDEBUG")
    if [ "$sanitizer" = "$minimal" ]; then headers='|hygiene\.(headers|snippets)'; fi # done by that compiler
    if [ "$long" = ON ]; then only='.*' less=(-DCMAKE_BUILD_TYPE=Release); fi
    MBSR_TEST_FEW=1 run 5 minimal "$minimal" "${less[@]}" "${linker[@]}" -DMBSR_UNITY=ON -DBUILD_SHARED_LIBS=OFF -DMBSR_IDA=OFF \
        -DMBSR_LAPACK=OFF -DMBSR_VECTORS="$long" -DMBSR_BENCH="$long" -DMBSR_HDF5=OFF -DMBSR_PNG=OFF -DMBSR_VIEWER=OFF \
        -DMBSR_TEST_ONLY="$only" -DMBSR_TEST_WITHOUT="$long_tests" -- -R "^($only)\$" -E "^($long_tests$headers)\$"
}

others >build/test-results/others.log 2>&1 &
first
wait $! || fails 6 "the other builds"
cat build/test-results/others.log

echo "==== closing lines"
cat build/test-results/*.line
if ls build/test-results/*.failed >/dev/null 2>&1; then
    echo "failed: $(cat build/test-results/*.failed | paste -sd ' ')"
    exit 1
fi
