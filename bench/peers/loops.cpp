/* Times forward dynamics of mechanisms with closed loops in another library.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   loops_NAME folder [samples]     lines of CSV on standard output, columns as of bench_loops
 *
 * Before a mechanism is timed, its accelerations are compared with those of the library. */
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
        model = library::open(m);
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

} // namespace

int main(int argc, char **argv)
{
    const int samples = argc > 2 ? std::atoi(argv[2]) : 15;
    if (argc < 2 || samples < 1) {
        fprintf(stderr, "usage: loops_%s folder [samples]\n", library::name);
        return 2;
    }
    std::vector<double> sample((size_t)samples);
    printf("# %s %s: %s\n", library::name, library::version().c_str(), library::timed);
    try {
        for (const char *name : mechanisms)
            measure(read_mechanism(argv[1], name), samples, sample.data());
    } catch (const std::exception &error) {
        fprintf(stderr, "loops_%s: %s\n", library::name, error.what());
        return 1;
    }
    return 0;
}
