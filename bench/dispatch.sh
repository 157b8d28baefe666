#!/usr/bin/env bash
# What handing out costs on many cores: a simulation of rank 0 and its workers, by the rule of src/program/team.c. A worker
# asks when its runs are done; rank 0 answers one request after the other, and dozes when there is none.
# SPDX-License-Identifier: BSD-3-Clause
# Usage: dispatch.sh [RUNS [MEAN [ANSWER [DOZE]]]]: number of runs; seconds of a run, of an answer, of a nap
set -eu
echo "workers,runs,seconds a run,spread,seconds,efficiency,rank 0 busy"
for workers in 1 10 100 1000 10000; do
    for spread in 0 1; do
        awk -v runs="${1:-1000000}" -v mean="${2:-0.01}" -v answer="${3:-2e-6}" -v doze="${4:-2e-4}" \
            -v workers=$workers -v spread=$spread '
        # a heap of times at which workers ask
        function push(time, k, up) {
            for (k = ++size; k > 1 && heap[up = int(k / 2)] > time; k = up) heap[k] = heap[up]
            heap[k] = time
        }
        function pop(least, last, k, down) {
            least = heap[1]; last = heap[size--]
            for (k = 1; (down = 2 * k) <= size; k = down) {
                if (down < size && heap[down + 1] < heap[down]) ++down
                if (heap[down] >= last) break
                heap[k] = heap[down]
            }
            heap[k] = last
            return least
        }
        # a run takes its mean, or a random time of that mean with an exponential distribution
        function work(count, sum, k) {
            if (!spread) return count * mean
            for (k = 0; k < count; ++k) sum -= log(1 - rand()) * mean
            return sum
        }
        BEGIN {
            srand(1)
            for (k = 0; k < workers; ++k) push(0)
            for (now = 0; next_run < runs; next_run += share) {
                asked = pop()
                if (asked > now) { # it dozes until a multiple of its nap behind the last answer
                    naps = int((asked - now) / doze)
                    now += (naps + 1) * doze
                }
                now += answer
                busy += answer
                share = int((runs - next_run) / (8 * workers))
                share = share < 1 ? 1 : share > 16 ? 16 : share
                took = work(share)
                all += took
                if (now + took > end) end = now + took
                push(now + took)
            }
            printf "%d,%d,%g,%s,%.4g,%.3f,%.4f\n", workers, runs, mean, spread ? "exponential" : "none", end, all / (workers * end), busy / end
        }'
    done
done
