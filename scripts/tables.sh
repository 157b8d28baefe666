#!/usr/bin/env bash
# Makes the tables of measurements in README.md and the documents from bench/results. A table stands between the
# lines "<!-- table NAME -->" and "<!-- end -->"; table_NAME below prints it.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: tables.sh [--check]     --check: writes nothing, and fails where a table differs
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
results=bench/results
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# rows FILE AWK...: the lines of a result, comments and head left out, by a program of awk.
rows() {
    local file=$results/$1.csv
    shift
    grep -v '^#' "$file" | tail -n +2 | awk -F, "$@"
}

# Functions of awk that write numbers as the documents do.
numbers='
    function digits(x, n,    e) {           # n digits, no exponent
        if (x == 0) return "0"
        e = int(log(x < 0 ? -x : x) / log(10) + 1e-9); if (x < 1 && x > -1) --e
        return e >= n - 1 ? sprintf("%.0f", x) : sprintf("%." (n - 1 - e) "f", x)
    }
    function grouped(n,    text, groups) {  # 12 345 from 10 000 on
        text = sprintf("%.0f", n)
        if (length(text) < 5) return text
        for (groups = ""; length(text) > 3; text = substr(text, 1, length(text) - 3))
            groups = " " substr(text, length(text) - 2) groups
        return text groups
    }
    function ns(x) { return x < 999.5 ? sprintf("%.0f", x) : digits(x / 1000, 2) " µs" }
    function short(x,    text) { text = sprintf("%.0e", x); sub(/e\+?/, "e", text); sub(/e-0/, "e-", text); sub(/e0+/, "e", text); sub(/e$/, "", text); return text }
'

# What others do with massless bodies, loops, stiff springs and flexible bodies, and what was measured beside them.
table_neighbours() {
    local costs
    costs=$(
        rows trees "$numbers"' $2 == "chain30" && $4 == "forward" { print "tree_" $1 "=" digits($9, 2) }'
        rows loop_runs "$numbers"' $1 == "fourbars" && $3 == 400 && $8 < 2e-4 && !($2 in seen) {
            seen[$2]; print "loop_" $2 "=" digits($7, 2) }'
        rows newton "$numbers"' $1 == "beam" && $2 == 400 && ($5 == "tree" && $6 == 1e-4 || $5 == "mujoco_Euler") {
            print "stiff_" $5 "=" digits($19, 2) }'
    )
    local tree_mbsrank tree_mujoco tree_simbody tree_rbdl tree_pinocchio loop_libmbsrank_rk4 loop_mujoco loop_rbdl
    local loop_pinocchio stiff_tree stiff_mujoco_Euler name
    while IFS='=' read -r name value; do
        case $name in *[!A-Za-z0-9_]*) ;; *) printf -v "$name" %s "$value" ;; esac
    done <<<"$costs"
    cat <<END
| | massless body | closed loop | stiff spring | flexible body | tree, ns | loops, s | stiff, s |
|---|---|---|---|---|---:|---:|---:|
| libmbsrank | anywhere; zero stays zero, its velocities are found | exact, multipliers in an index-1 DAE; redundant rows named | any stiffness at the cost of a rigid joint | modes, beams, finite elements, SID; static modes without mass | $tree_mbsrank | $loop_libmbsrank_rk4 | $stiff_tree |
| MuJoCo | refused on a joint: mass and inertia above \`mjMINVAL\` | soft equality constraints | a force; implicit integrators | soft constraints between many bodies | $tree_mujoco | $loop_mujoco | $stiff_mujoco_Euler |
| Pinocchio | links before one with mass | \`constraintDynamics\`, proximal | your force | – | $tree_pinocchio | $loop_pinocchio | – |
| RBDL | links before one with mass | \`ConstraintSet\`, Baumgarte optional | your force | – | $tree_rbdl | $loop_rbdl | – |
| Simbody | not at the end of a branch | constraints, projected | a force | – | $tree_simbody | – | – |
| Drake | not at the end of a branch | constraints of discrete plants, or bushings | a force | deformable bodies by finite elements | – | – | – |
| MBDyn | static nodes, held by joints or elastic elements | constraints in redundant coordinates | elastic joints | beams, membranes, modal joint | – | – | – |
END
}

# Reduction of solids from finite elements.
table_fe() {
    echo '| dofs | entries of the factor | s | MB | frequencies | deflections |'
    echo '|---:|---:|---:|---:|---:|---:|'
    rows fe "$numbers"' { printf "| %s (%s) | %s | %s | %s | %s | %s |\n",
        grouped($2), $1, $4 == "" ? "–" : sprintf("%.1e", $4), digits($6, 2), $12, short($13), short($14) }'
}

# Time per body of chains with bodies of several kinds.
table_kinds() {
    echo '| chain | forward dynamics | inverse dynamics | momentum residual | factor + solve |'
    echo '|---|---:|---:|---:|---:|'
    rows kinds "$numbers"'
        BEGIN {
            n = split("space,100|in space, stock hinges;one_own_joint,100|one own hinge;ten_own_joints,100|ten own hinges;" \
                "all_joints_own,100|all hinges own;all_joints_by_hand,100|all hinges by hand;general,100|ten general bodies;" \
                "general_given,100|the same, derivatives of their joints given;plane,100|in the plane;" \
                "plane,1000|in the plane, 1000 bodies;one_pair,100|one rod on two massless slides at the end;" \
                "one_point,100|one mass point on a ball joint at the end;sliders,99|rods on two massless slides each, 99 bodies;" \
                "points,100|mass points on ball joints;dummies,99|ball joints of three hinges with dummy bodies, 99 bodies;" \
                "balls,33|the same in one piece, 33 bodies", names, ";")
        }
        { time[$1 "," $2 "," $3] = $4 }
        END {
            for (k = 1; k <= n; ++k) {
                split(names[k], name, "|")
                c = name[1] ","
                if (!((c "forward") in time)) { print "tables.sh: no " c >"/dev/stderr"; exit 1 }
                printf "| %s | %s | %s | %s | %s |\n", name[2], ns(time[c "forward"]), ns(time[c "inverse"]),
                    ns(time[c "residual"]), ns(time[c "factor_solve"])
            }
        }'
}

# Other libraries on the same trees: forward or inverse dynamics, median ns a body.
table_trees() {
    local libraries="mbsrank mbsrank_clang mbsrank_baseline pinocchio rbdl mujoco bullet simbody"
    local names='| libmbsrank | same, clang | same, `baseline` | Pinocchio 3.7 | RBDL 3.3 | MuJoCo 2.2.2 | Bullet 3.24 | Simbody 3.7 |'
    if [ "$1" = inverse ]; then libraries=${libraries/ bullet/} names=${names/ Bullet 3.24 |/}; fi
    echo "| $1 dynamics $names"
    echo "|---$(sed 's/[a-z_]\+ */|---:/g' <<<"$libraries")|"
    rows trees -v call="$1" -v libraries="$libraries" "$numbers"'
        $4 == call { time[$1 "," $2] = $9 }
        END {
            n = split(libraries, library, " ")
            trees = split("chain7 chain30 humanoid36 btree1023 chain1000", tree, " ")
            for (k = 1; k <= trees; ++k) {
                printf "| %s |", tree[k]
                for (j = 1; j <= n; ++j) {
                    c = library[j] "," tree[k]
                    printf " %s |", c in time ? grouped(time[c]) : "–"
                }
                print ""
            }
        }'
}
table_trees_forward() { table_trees forward; }
table_trees_inverse() { table_trees inverse; }

# One evaluation by two threads.
table_threads() {
    echo '| | forward | inverse | residual |'
    echo '|---|---:|---:|---:|'
    rows threads "$numbers"'
        function name() {
            if ($1 == "batch") return grouped($3) " states of a chain of " $2 ", a batch"
            return ($1 == "binary" ? "binary tree of " : "two chains, together ") grouped($2)
        }
        $2 == 1023 || $1 == "two_chains" && $2 > 200000 { next }
        name() != last { if (last != "") print line (calls < 3 ? " |" : ""); last = name(); line = "| " last " |"; calls = 0 }
        { ++calls; line = line " " digits($6, 3) " → " digits($7, 3) " |" }
        END { print line (calls < 3 ? " |" : "") }'
}

# Steps of fixed size.
table_stepper() {
    echo '| model | h | order | residual | factorisation | step: median | in residuals | 99.99 % below | most residuals |'
    echo '|---|---|---|---:|---:|---:|---:|---:|---:|'
    rows stepper "$numbers"'
        function time(us) { return us < 1000 ? digits(us, us < 20 ? 3 : 2 + (us >= 100)) " µs" : digits(us / 1000, 2) " ms" }
        $1 == "histogram" { exit }
        {
            model = $1
            sub(/_kept/, ", kept", model)
            printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", model, $1 == "ragdoll" ? "1/60 s" : "1 ms", $2,
                time($4), time($5), time($7), $11, time($9), $14
        }'
}

# Contact: errors against closed forms and what they cost; MuJoCo beside it.
table_contact() {
    echo '| case | program, tolerance or step | error | processor, s | simulated, s | steps |'
    echo '|---|---|---:|---:|---:|---:|'
    rows contact "$numbers"'
        BEGIN {
            n = split("rolling_y|slab under balls, along y (m²/s²);rolling_xy|the same, obliquely (m²/s²);bouncing|49 balls without loss (J²);" \
                "elastic_balls_27|27 balls without loss (J²);elastic_balls_125|125 balls without loss (J²);elastic_balls_216|216 balls without loss (J²);dull_balls_216|216 dull balls, depths (m²);stack|ten boxes, way from rest (m);sledges|20 bodies, 40 contacts", names, ";")
            for (k = 1; k <= n; ++k) { split(names[k], pair, "|"); name[pair[1]] = pair[2] }
        }
        function named(x) { if (x in name) return name[x]; sub(/^box_of_/, "", x); return x " spheres in a box" }
        {
            setting = $3
            split($3, part, " ")
            if ($2 == "mujoco") setting = "MuJoCo 3.14, " short(part[3]) " s"
            else setting = part[1] == "steps" ? "fixed steps, " short(part[3]) " s" : short($3)
            printf "| %s | %s | %s | %s | %s | %d |\n", named($1), setting, $4 == "nan" ? "–" : $4 == 0 ? "0" : short($4), digits($5, 2), $6, $7
        }'
}

# What outputs of a run cost beside a step.
table_outputs() {
    echo '| model | step | output | over a step | raw output |'
    echo '|---|---:|---:|---:|---:|'
    rows outputs "$numbers"'
        BEGIN {
            n = split("quarter_car,4|quarter car, massless mount on a damper;quarter_car_on_springs,4|the same on a spring (index 2);" \
                "chain,20|chain of 20 rods;chain_with_mounts,30|10 rods with a massless mount each;chain_with_mounts,300|100 of them;" \
                "chain_with_mounts_on_springs,30|10 rods, mounts on springs (index 2);four_bars,90|30 four-bar linkages;" \
                "four_bars_massless,90|the same, massless couplers", names, ";")
        }
        { line[$1 "," $2] = digits($6, 2) " µs | " digits($7, $7 < 100 ? 2 : 3) " µs | " digits($9, 2) " | " digits($8, 1) " µs |" }
        END { for (k = 1; k <= n; ++k) { split(names[k], name, "|"); print "| " name[2] " | " line[name[1]] } }'
}

# Flexible bodies by the number of their modes, and joint blocks in factors beside those in one piece.
table_flexible_modes() {
    echo '| normal modes | forward dynamics | residual | factor and solve |'
    echo '|---:|---:|---:|---:|'
    rows flexible "$numbers"'
        $1 == "modes" && $3 != 12 && $3 != 24 { time[$3 "," $4] = digits($5 / 1000, 3); if ($4 == "forward") order[++n] = $3 }
        END { for (k = 1; k <= n; ++k) { c = order[k] ","; print "| " order[k] " | " time[c "forward"] " | " time[c "residual"] " | " time[c "factor_solve"] " |" } }'
}
table_flexible_factors() {
    echo '| modes | in factors | in one piece | residual in factors | in one piece |'
    echo '|---:|---:|---:|---:|---:|'
    rows flexible "$numbers"'
        { time[$1 "," $3 "," $4] = digits($5 / 1000, 3) }
        $1 ~ /_blocks$/ && $4 == "forward" { order[++n] = $1 "," $3 }
        END {
            for (k = 1; k <= n; ++k) {
                split(order[k], c, ",")
                plain = c[1]
                sub(/_blocks/, "", plain)
                a = plain "," c[2] ","
                b = order[k] ","
                print "| " c[2] (plain == "waves" ? " (`waves`)" : c[2] == 128 ? " (in one piece bounds do not tell the rank)" : "") \
                    " | " time[a "forward"] " | " time[b "forward"] " | " time[a "residual"] " | " time[b "residual"] " |"
            }
        }'
}

# Whole runs of closed mechanisms: steps and milliseconds.
table_loop_runs() {
    echo '| mechanism, time | tolerance | error (rad) | driver | RK4, libmbsrank | RK4, Pinocchio | RK4, RBDL | RK4, MuJoCo |'
    echo '|---|---|---:|---:|---:|---:|---:|---:|'
    rows loop_runs "$numbers"'
        function cost() { return grouped($6) ": " ($7 * 1000 >= 9999.5 ? grouped(sprintf("%.3g", $7 * 1000) + 0) : digits($7 * 1000, $7 >= 0.1 ? 3 : 2)) }
        {
            model = $1 "," $3
            if (!(model in known)) { known[model] = 1; order[++n] = model }
            if ($2 == "libmbsrank") { ++runs[model]; tolerance[model, runs[model]] = $5; error[model, runs[model]] = sprintf("%.1e", $8); run[model, runs[model]] = cost() }
            else { ++others[model, $2]; run[model, $2, others[model, $2]] = cost() }
        }
        END {
            split("fourbars,40|10 four-bars, 1 s;fourbars,400|100, 0.5 s;ring,10|ring of 10, 0.3 s;ring,100|100, 0.3 s", names, ";")
            split("libmbsrank_rk4 pinocchio rbdl mujoco", library, " ")
            for (k = 1; k <= 4; ++k) {
                split(names[k], name, "|")
                for (j = 1; j <= runs[name[1]]; ++j) {
                    printf "| %s | %s | %s | %s |", j == 1 ? name[2] : "", "1e-" (2 + j), error[name[1], j], run[name[1], j]
                    for (l = 1; l <= 4; ++l) printf " %s |", run[name[1], library[l], j]
                    print ""
                }
            }
        }' | sed 's/^|  |/| |/'
}

# Accelerations of closed mechanisms beside other libraries, ns a body.
table_loop_peers() {
    echo '| | 40 bodies in four-bars | 400 | ring of 10 | 100 |'
    echo '|---|---:|---:|---:|---:|'
    rows loops "$numbers"'
        $5 == "forward" { time[$2 "," $1 "," $3] = $6 }
        END {
            n = split("closed|libmbsrank, `mbsr_forward_dynamics`;pinocchio|Pinocchio 3.7, `constraintDynamics`, proximal;" \
                "rbdl|RBDL 3.3, `ForwardDynamicsConstraintsRangeSpaceSparse`;mujoco|MuJoCo 2.2, `mj_forward`, constraints as hard as it takes them", names, ";")
            split("fourbars,40 fourbars,400 ring,10 ring,100", model, " ")
            for (k = 1; k <= n; ++k) {
                split(names[k], name, "|")
                printf "| %s |", name[2]
                for (j = 1; j <= 4; ++j) printf " %s |", grouped(time[name[1] "," model[j]])
                print ""
            }
        }'
}

# The pendulum on a bead: steps and errors of the forms with the driver.
table_bead() {
    echo '| bead | form | rtol = atol = 1e-4 | 1e-6 | 1e-8 | 1e-10 |'
    echo '|---|---|---:|---:|---:|---:|'
    rows precision "$numbers"'
        $1 == "bead" && $3 == 5 { run[$2 "," $4 "," $5] = $6 == "ok" ? grouped($7) " (" short($14) ")" : "fails" }
        END {
            split("0 1e-06 0.001", mass, " ")
            split("0 kg|1e-6 kg|1e-3 kg", said, "|")
            split("momentum|index1|recursive|inverse_dynamics", form, "|")
            split("momentum|index-1|recursive|inverse dynamics", name, "|")
            split("0.0001 1e-06 1e-08 1e-10", tolerance, " ")
            for (k = 1; k <= 3; ++k)
                for (j = 1; j <= 4; ++j) {
                    printf "| %s | %s |", j == 1 ? said[k] : "", name[j]
                    for (l = 1; l <= 4; ++l) printf " %s |", run[mass[k] "," form[j] "," tolerance[l]]
                    print ""
                }
        }' | sed 's/^|  |/| |/'
}

# Closed mechanisms, ns a body; KLU on the same in redundant coordinates.
table_loops() {
    echo '| model | residual | forward dynamics | inverse dynamics with motors | factor | solve | KLU: factor | solve |'
    echo '|---|---:|---:|---:|---:|---:|---:|---:|'
    rows loops "$numbers"'
        { time[$1 "," $2 "," $3 "," $5] = $6 }
        function of(model, bodies, variant, call,    c) {
            c = model "," variant "," bodies "," call
            return c in time ? " " sprintf("%.0f", time[c]) " |" : " |"
        }
        END {
            n = split("chain of 10 four-bars,fourbars,closed,40;100,fourbars,closed,400;1000,fourbars,closed,4000;" \
                "10 000,fourbars,closed,40000;chain of 10 four-bars without mass in the couplers,fourbars,massless,40;" \
                "100,fourbars,massless,400;chain of 10 with pins of 1e10 N/m,fourbars,stiff,40;1000,fourbars,stiff,4000;" \
                "one loop of 10 rods,ring,closed,10;100,ring,closed,100;1000,ring,closed,1000;" \
                "chain of 1000 four-bars without pins (by blocks),fourbars,by_blocks,4000;chain of 100 four-bars in space,linkages,hinges,400;" \
                "chain of 10 with couplers on universal joints,linkages,universal,40;100,linkages,universal,400;1000,linkages,universal,4000;" \
                "100 of these couplers without mass,linkages,universal massless,400;chain of 10 with couplers on ball joints,linkages,ball,40;" \
                "100,linkages,ball,400;1000,linkages,ball,4000;chain of 10 rods in space each geared to the one before,gears,closed,10;" \
                "100,gears,closed,100;1000,gears,closed,1000;chain of 10 hands of five fingers,hands,closed,160;100,hands,closed,1600", names, ";")
            for (k = 1; k <= n; ++k) {
                split(names[k], c, ",")
                klu = c[3] == "closed" ? "klu" : "none"
                print "| " c[1] " |" of(c[2], c[4], c[3], "residual") of(c[2], c[4], c[3], "forward") of(c[2], c[4], c[3], "inverse") \
                    of(c[2], c[4], c[3], "factor") of(c[2], c[4], c[3], "solve") of(c[2], c[4], klu, "factor") of(c[2], c[4], klu, "solve")
            }
        }'
}

# Whole runs of stiff trees by IDA at 1e-4, seconds. MuJoCo: the fastest run that is at least as accurate.
table_newton() {
    echo '| model | bodies | unknowns | steps | on the tree | KLU | dense | LAPACK | MuJoCo, as accurate |'
    echo '|---|---:|---:|---:|---:|---:|---:|---:|---:|'
    rows newton "$numbers"'
        { model = $1 "," $2 }
        $6 == 1e-4 && $7 == "ok" {
            if ($5 == "tree") { order[++n] = model; unknowns[model] = $4; steps[model] = $8; error[model] = $22 + 0 }
            time[model, $5] = digits($19, $19 < 0.01 ? 1 : 2)
        }
        $5 ~ /^mujoco/ && $7 == "ok" {
            if ($22 != "" && $22 + 0 <= error[model] && (!(model in best) || $19 + 0 < best[model])) best[model] = $19 + 0
            if ($19 + 0 > longest[model, $5]) longest[model, $5] = $19 + 0
        }
        function of(solver) { return (model, solver) in time ? time[model, solver] : "–" }
        function mujoco(    least, k, kind) {
            if (model in best) return digits(best[model], 2)
            split("mujoco_Euler mujoco_implicit", kind, " ")
            for (k = 1; k <= 2; ++k) if ((model, kind[k]) in longest && (least == 0 || longest[model, kind[k]] < least)) least = longest[model, kind[k]]
            return least ? "more than " digits(least, 2) : "–"
        }
        END {
            for (k = 1; k <= n; ++k) {
                model = order[k]
                split(model, c, ",")
                gsub(/_/, " ", c[1])
                if (c[1] == "vehicle") c[1] = "vehicle, 50 links without mass"
                if (c[1] == "tree") c[1] = "random tree, a third without mass"
                print "| " c[1] " | " grouped(c[2]) " | " grouped(unknowns[model]) " | " steps[model] " | " of("tree") \
                    ((model, "krylov") in time ? " (GMRES " of("krylov") ")" : "") " | " of("klu") " | " of("dense") " | " of("lapack") " | " mujoco() " |"
            }
        }'
}

# Two oscillators in a row: steps and errors of the forms.
table_oscillators() {
    echo '| m1 | form | 1e-4 | 1e-6 | 1e-8 | 1e-10 |'
    echo '|---|---|---:|---:|---:|---:|'
    rows precision "$numbers"'
        $1 == "oscillators" { run[$2, $4, $5] = grouped($7) " (" short($14) ")" }
        END {
            split("0 1e-06 0.0001", mass, " ")
            split("0 1e-6 1e-4", said, " ")
            split("momentum index1 recursive", form, " ")
            split("momentum|index-1|recursive", name, "|")
            split("0.0001 1e-06 1e-08 1e-10", tolerance, " ")
            for (k = 1; k <= 3; ++k)
                for (j = 1; j <= 3; ++j) {
                    printf "| %s| %s |", j == 1 ? said[k] " " : "", name[j]
                    for (l = 1; l <= 4; ++l) printf " %s |", run[mass[k], form[j], tolerance[l]]
                    print ""
                }
        }'
}

# The bead on springs alone (index 2): steps and errors of the forms with the driver.
table_springs() {
    echo '| form, by the driver | 1e-4 | 1e-6 | 1e-8 | 1e-10 |'
    echo '|---|---:|---:|---:|---:|'
    rows precision "$numbers"'
        $1 == "bead" && $2 == 0 && $3 == 0 { run[$4, $5] = $6 == "ok" ? grouped($7) " (" short($14) ")" : "fails" }
        END {
            n = split("momentum|index1|inverse_dynamics|recursive|momentum_all_tested", form, "|")
            split("momentum|index-1|inverse dynamics|recursive|momentum, all tested", name, "|")
            split("0.0001 1e-06 1e-08 1e-10", tolerance, " ")
            for (k = 1; k <= n; ++k) {
                printf "| %s |", name[k]
                for (l = 1; l <= 4; ++l) printf " %s |", run[form[k], tolerance[l]]
                print ""
            }
        }'
}

# Newton systems of trees beside forward dynamics, median ns a body.
table_newton_trees() {
    echo '| tree | forward dynamics | factor | solve | factor + solve, in forward dynamics |'
    echo '|---|---:|---:|---:|---:|'
    rows trees "$numbers"'
        $1 == "mbsrank" { time[$2, $4] = $9 }
        END {
            n = split("chain7 chain30 humanoid36 btree1023 chain1000 half_massless1000 made10000 made100000 made1000000", tree, " ")
            for (k = 1; k <= n; ++k) {
                forward = time[tree[k], "forward"]
                factor = time[tree[k], "newton_factor"]
                solve = time[tree[k], "newton_solve"]
                printf "| %s | %.0f | %.0f | %.0f | %.1f |\n", tree[k], forward, factor, solve, (factor + solve) / forward
            }
        }'
}

# Stages of planar trees, ns a body against the number of bodies, and the slopes of their times.
shapes='
    BEGIN {
        split("chain,0.00 chain,0.25 binary,0.25 random_depth_first,0.25 random,0.25", shape, " ")
        split("chain, no dummy links|chain|binary|random, depth first|random", said, "|")
    }
'
table_scaling() {
    echo '| N | 10 | 100 | 1000 | 10 000 | 100 000 |'
    echo '|---|---:|---:|---:|---:|---:|'
    rows scaling -v stage="$1" "$numbers$shapes"'
        $3 == stage { time[$1 "," $2, $4] = $6 }
        END {
            for (k = 1; k <= 5; ++k) {
                printf "| %s |", said[k]
                for (N = 10; N <= 100000; N *= 10) printf " %.0f |", time[shape[k], N]
                print ""
            }
        }'
}
table_scaling_recursive() { table_scaling residual_recursive; }
table_scaling_inverse() { table_scaling residual_inverse_dynamics; }
table_scaling_slopes() {
    echo '| | positions | velocities | forces | backward | forward | residual, recursive | residual, inverse dynamics |'
    echo '|---|---:|---:|---:|---:|---:|---:|---:|'
    sed -n 's/^# \([a-z_]*,0[.0-9]*,[a-z_]*,[.0-9]*\),.*/\1/p' "$results/scaling.csv" | awk -F, "$shapes"'
        { slope[$1 "," $2, $3] = $4 }
        END {
            n = split("positions velocities forces backward forward residual_recursive residual_inverse_dynamics", stage, " ")
            for (k = 1; k <= 5; ++k) {
                printf "| %s |", said[k]
                for (j = 1; j <= n; ++j) printf " %.3f |", slope[shape[k], stage[j]]
                print ""
            }
        }'
}

# Time of reading files.
table_files() {
    echo '| | bodies | MB | ms | MB/s | bodies/s |'
    echo '|---|---:|---:|---:|---:|---:|'
    rows files "$numbers"' { printf "| %s | %s | %.1f | %.0f | %.0f | %s |\n", toupper($1), grouped($2), $3, $4, $8, grouped($9) }'
}

table_python() {
    echo '| a call, 7 bodies, µs | Python | bare C call by cffi | more |'
    echo '|---|---:|---:|---:|'
    rows python '{ printf "| %s | %s | %s | %s |\n", $1, $2, $3, $4 }'
}

# fill FILE: the file with its tables made anew.
fill() {
    local line name
    while IFS= read -r line || [ -n "$line" ]; do
        case $line in
        '<!-- table '*' -->')
            name=${line#<!-- table }
            name=${name% -->}
            printf '%s\n' "$line"
            "table_$name"
            while IFS= read -r line && [ "$line" != '<!-- end -->' ]; do :; done
            ;;
        esac
        printf '%s\n' "$line"
    done <"$1"
}

status=0
count=0
for document in README.md docs/*.md bench/README.md; do
    grep -q '^<!-- table ' "$document" || continue
    count=$((count + $(grep -c '^<!-- table ' "$document")))
    fill "$document" >"$work/filled"
    if [ "${1:-}" = --check ]; then
        diff -u "$document" "$work/filled" || { echo "$document: run scripts/tables.sh"; status=1; }
    elif ! cmp -s "$document" "$work/filled"; then
        cat "$work/filled" >"$document"
    fi
done
echo "$count tables"
[ "$count" -gt 0 ] || status=1
exit $status
