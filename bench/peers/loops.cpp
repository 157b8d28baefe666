/* Mechanisms with closed loops in another library: times of forward dynamics, and whole runs.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   loops_NAME folder [samples]     lines of CSV on standard output, columns as of bench_loops
 *   loops_NAME --runs folder        likewise of bench_loop_runs
 *
 * Before a mechanism is timed, its accelerations are compared with those of the library. Runs go by
 * the Runge-Kutta method of order 4, in as many steps (5, 10, 20 and so on) as it takes to be no
 * farther from the reference than the library's run is; those that would take more than 20 s are
 * left out, and say so. */
#include "loops.h"

extern "C" {
#include "bench.h"
}

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>

namespace
{

const char *const mechanisms[] = {"fourbars_10", "fourbars_100", "ring_10", "ring_100"};
const double sample_time = 5e-3;

loops_mechanism read_mechanism(const std::string &folder, const std::string &name)
{
    loops_mechanism m{name, {}, {}};
    std::ifstream text(folder + "/" + name + ".loops");
    size_t rods = 0, pins = 0;
    text >> rods >> pins;
    m.rod.resize(rods);
    m.pin.resize(pins);
    for (loops_rod &r : m.rod)
        text >> r.parent >> r.x >> r.y >> r.angle >> r.acceleration >> r.mass >> r.length >>
            r.inertia;
    for (loops_pin &p : m.pin) text >> p.a >> p.on_a >> p.b >> p.on_b;
    if (!text || rods == 0) throw std::runtime_error("cannot read " + folder + "/" + name);
    return m;
}

/* The largest difference, over the largest acceleration. */
double defect_of(const loops_model &model, const loops_mechanism &m)
{
    double most = 0.0, size = 0.0;
    for (size_t k = 0; k < m.rod.size(); ++k) {
        const double one = std::fabs(model.acceleration((int)k) - m.rod[k].acceleration);
        if (!(one <= most)) most = one; /* a NaN stays */
        size = std::max(size, std::fabs(m.rod[k].acceleration));
    }
    return most / size;
}

void time_one(loops_model &model, const loops_mechanism &m, int samples, double *sample)
{
    const size_t cut = m.name.find('_');
    for (int j = 0; j < samples; ++j) {
        const double before = bench_now();
        double passed = 0.0;
        int calls = 0;
        while (passed < sample_time) {
            model.forward();
            ++calls;
            passed = bench_now() - before;
        }
        sample[j] = 1e9 * passed / calls / (double)m.rod.size();
    }
    const bench_quartiles s = bench_statistics(samples, sample);
    printf("%s,%s,%zu,%zu,forward,%.0f,%.0f,%.0f\n", m.name.substr(0, cut).c_str(), library::name,
           m.rod.size(), 2 * m.pin.size(), s.median, s.q1, s.q3);
}

void measure(const loops_mechanism &m, int samples, double *sample)
{
    std::unique_ptr<loops_model> model;
    try {
        model = library::open(m, 1e-4);
        model->forward();
    } catch (const std::exception &error) {
        printf("# %s: %s refused: %s\n", library::name, m.name.c_str(), error.what());
        return;
    }
    const double defect = defect_of(*model, m);
    const bool good = defect <= library::largest_defect;
    printf("# %s: %s, wrong by %.2g of the largest acceleration%s\n", library::name, m.name.c_str(),
           defect, good ? "" : ", not timed");
    if (good) time_one(*model, m, samples, sample);
}

/* ---- whole runs ---- */

/* Angles, then their rates. */
struct state {
    std::vector<double> q, v;
};

struct target {
    double time, error;
    std::vector<double> q;
};

target read_target(const std::string &path, size_t rods)
{
    target t;
    std::ifstream text(path);
    t.q.resize(rods);
    text >> t.time >> t.error;
    for (double &x : t.q) text >> x;
    if (!text) throw std::runtime_error("cannot read " + path);
    return t;
}

/* x + h (q', v') with the rates v' as found last. */
state moved(const state &x, const std::vector<double> &v, const loops_model &model, double h)
{
    state to = x;
    for (size_t k = 0; k < x.q.size(); ++k) {
        to.q[k] += h * v[k];
        to.v[k] += h * model.acceleration((int)k);
    }
    return to;
}

void step(loops_model &model, state &x, double h)
{
    const double share[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, at[4] = {0.5, 0.5, 1.0};
    const state from = x;
    state stage = x;
    for (int k = 0; k < 4; ++k) {
        model.forward_at(stage.q, stage.v);
        x = moved(x, stage.v, model, share[k] * h);
        if (k < 3) stage = moved(from, stage.v, model, at[k] * h);
    }
}

/* How far pins are open. */
double gap(const loops_mechanism &m, const std::vector<double> &q)
{
    std::vector<double> x(m.rod.size() + 1), y(x), angle(x); /* the world first */
    for (size_t k = 0; k < m.rod.size(); ++k) {
        const size_t on = (size_t)(m.rod[k].parent + 1);
        const double c = std::cos(angle[on]), s = std::sin(angle[on]);
        x[k + 1] = x[on] + c * m.rod[k].x - s * m.rod[k].y;
        y[k + 1] = y[on] + s * m.rod[k].x + c * m.rod[k].y;
        angle[k + 1] = angle[on] + q[k];
    }
    double most = 0.0;
    for (const loops_pin &p : m.pin) {
        const size_t a = (size_t)(p.a + 1), b = (size_t)(p.b + 1);
        most = std::max(
            most,
            std::hypot(x[a] + p.on_a * std::cos(angle[a]) - x[b] - p.on_b * std::cos(angle[b]),
                       y[a] + p.on_a * std::sin(angle[a]) - y[b] - p.on_b * std::sin(angle[b])));
    }
    return most;
}

double distance(const std::vector<double> &a, const std::vector<double> &b)
{
    double most = 0.0;
    for (size_t k = 0; k < a.size(); ++k) {
        const double one = std::fabs(a[k] - b[k]);
        if (!(one <= most)) most = one; /* a NaN stays */
    }
    return most;
}

/* One run in so many steps; its CPU time, s, or what it would be where that is more than `limit`.
 */
double integrate(loops_model &model, state &x, double h, long steps, double limit)
{
    const double before = bench_now();
    for (long k = 0; k < steps; ++k) {
        step(model, x, h);
        const double all = (bench_now() - before) / (double)(k + 1) * (double)steps;
        if (k >= 3 && all > limit) return all;
    }
    return bench_now() - before;
}

void run(const loops_mechanism &m, const target &t)
{
    const double limit = 20.0;
    const size_t cut = m.name.find('_');
    for (long steps = 5; steps <= 5L << 20; steps *= 2) {
        const double h = t.time / (double)steps;
        const std::unique_ptr<loops_model> model = library::open(m, h);
        state x;
        for (const loops_rod &r : m.rod) x.q.push_back(r.angle);
        x.v.resize(x.q.size());
        const double seconds = integrate(*model, x, h, steps, limit), error = distance(x.q, t.q);
        const bool left_out = seconds > limit;
        if (!left_out && !(error <= t.error)) continue;
        printf("%s,%s,%zu,%zu,%g,%ld,%.3g,", m.name.substr(0, cut).c_str(), library::name,
               m.rod.size(), 2 * m.pin.size(), h, steps, seconds);
        if (left_out)
            printf(",\n");
        else
            printf("%.2e,%.1e\n", error, gap(m, x.q));
        fflush(stdout);
        return;
    }
}

void run_all(const std::string &folder)
{
    for (const char *name : mechanisms) {
        const loops_mechanism m = read_mechanism(folder, name);
        for (int exponent = 3; exponent <= 6; ++exponent)
            run(m, read_target(folder + "/" + name + "_" + std::to_string(exponent) + ".run",
                               m.rod.size()));
    }
}

} // namespace

int main(int argc, char **argv)
{
    const bool runs = argc == 3 && std::string(argv[1]) == "--runs";
    const int samples = argc > 2 && !runs ? std::atoi(argv[2]) : 15;
    if (argc < 2 || samples < 1) {
        fprintf(stderr, "usage: loops_%s folder [samples]\n       loops_%s --runs folder\n",
                library::name, library::name);
        return 2;
    }
    std::vector<double> sample((size_t)samples);
    printf("# %s %s: %s%s\n", library::name, library::version().c_str(), library::timed,
           runs ? ", in RK4; blank errors: left out, cpu_s from the first steps" : "");
    try {
        if (runs) {
            run_all(argv[2]);
            return 0;
        }
        for (const char *name : mechanisms)
            measure(read_mechanism(argv[1], name), samples, sample.data());
    } catch (const std::exception &error) {
        fprintf(stderr, "loops_%s: %s\n", library::name, error.what());
        return 1;
    }
    return 0;
}
