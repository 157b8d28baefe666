/* Times forward and inverse dynamics of the trees of a folder in another library.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   peer_NAME folder [samples]     CSV on standard output, columns as of bench_trees
 *
 * Before a tree is timed, its accelerations are compared with the reference, and its joint forces
 * with those that the reference was computed for. */
#include "peer.h"

extern "C" {
#include "bench.h"
}

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <sstream>
#include <stdexcept>

/* Jacobi rotations, by turns in the planes xy, yz and zx. */
peer_axes peer_principal(const peer_body &b)
{
    const auto &I = b.inertia;
    double T[3][3] = {{I[0], I[3], I[4]}, {I[3], I[1], I[5]}, {I[4], I[5], I[2]}};
    peer_axes a = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
    for (int turn = 0; turn < 60; ++turn) {
        const int k = turn % 3, l = (k + 1) % 3;
        if (T[k][l] == 0.0) continue;
        const double angle = 0.5 * std::atan(2.0 * T[k][l] / (T[l][l] - T[k][k])),
                     c = std::cos(angle), s = std::sin(angle);
        const auto rotate = [c, s](double &x, double &y) {
            const double first = c * x - s * y;
            y = s * x + c * y;
            x = first;
        };
        for (int r = 0; r < 3; ++r) rotate(T[r][k], T[r][l]);
        for (int r = 0; r < 3; ++r) rotate(T[k][r], T[l][r]);
        for (int r = 0; r < 3; ++r) rotate(a.R[r][k], a.R[r][l]);
    }
    for (size_t k = 0; k < 3; ++k) a.moments[k] = T[k][k];
    return a;
}

namespace
{

const char *const trees[] = {"massless_iii", "chain7",    "chain30",
                             "humanoid36",   "btree1023", "chain1000"};
const double sample_time = 5e-3;
const double largest_defect = 1e-7; /* a solver of the mass matrix may lose digits */

template <size_t n> void read(std::istream &in, std::array<double, n> &x)
{
    for (double &one : x) in >> one;
}

template <size_t n> void normalise(std::array<double, n> &x)
{
    double square = 0.0;
    for (double one : x) square += one * one;
    for (double &one : x) one /= std::sqrt(square);
}

std::vector<double> section(std::istream &in, const char *key)
{
    std::string word;
    size_t count = 0;
    in >> word >> count;
    if (!in || word != key) throw std::runtime_error(std::string("no section ") + key);
    std::vector<double> x(count);
    for (double &one : x) in >> one;
    if (!in) throw std::runtime_error(std::string("too short: ") + key);
    return x;
}

peer_tree read_tree(const std::string &folder, const std::string &name)
{
    peer_tree tree{name, false, {}, {}, {}, {}, {}};
    std::ifstream text(folder + "/" + name + ".txt"), ref(folder + "/" + name + ".ref");
    if (!text || !ref) throw std::runtime_error("cannot read " + folder + "/" + name);
    peer_body b;
    while (text >> b.parent >> b.type) {
        read(text, b.axis);
        read(text, b.place);
        read(text, b.turn);
        text >> b.mass;
        read(text, b.com);
        read(text, b.inertia);
        if (!text) throw std::runtime_error("too short: " + name);
        normalise(b.axis);
        normalise(b.turn);
        tree.free_root = tree.free_root || b.type == 'F';
        tree.body.push_back(b);
    }
    tree.q = section(ref, "q");
    tree.v = section(ref, "v");
    tree.tau = section(ref, "tau");
    tree.qdd = section(ref, "qdd");
    return tree;
}

double largest(const std::vector<double> &x)
{
    double most = 0.0;
    for (double one : x) most = std::max(most, std::fabs(one));
    return most;
}

double difference(const std::vector<double> &x, const std::vector<double> &should)
{
    double most = x.size() == should.size() ? 0.0 : INFINITY;
    for (size_t k = 0; k < std::min(x.size(), should.size()); ++k) {
        const double one = std::fabs(x[k] - should[k]);
        if (!(one <= most)) most = one; /* a NaN stays */
    }
    return most;
}

/* Joint forces are small differences of large ones in a long tree: they are compared with those
 * that it takes when every other acceleration has the opposite sign. */
double inverse_defect(peer_model &model, const peer_tree &tree)
{
    std::vector<double> other = tree.qdd;
    for (size_t k = 0; k < other.size(); k += 2) other[k] = -other[k];
    model.accelerate(other);
    model.inverse();
    const double size = std::max(largest(tree.tau), largest(model.joint_forces()));
    model.accelerate(tree.qdd);
    model.inverse();
    return difference(model.joint_forces(), tree.tau) / size;
}

struct candidate {
    peer_tree tree;
    std::unique_ptr<peer_model> model;
    std::string refusal;
    double build, defect[2];
    int repeats[2];
};

void call(candidate &c, int which)
{
    if (which == 0)
        c.model->forward();
    else
        c.model->inverse();
}

/* Seconds per call. */
double time_call(candidate &c, int which)
{
    const double begin = bench_now();
    for (int k = 0; k < c.repeats[which]; ++k) call(c, which);
    return (bench_now() - begin) / c.repeats[which];
}

candidate open_candidate(const std::string &folder, const char *name)
{
    candidate c{read_tree(folder, name), nullptr, "", 0.0, {0.0, 0.0}, {1, 1}};
    const double begin = bench_now();
    try {
        c.model = library::open(c.tree);
        call(c, 0);
    } catch (const std::exception &error) {
        c.refusal = error.what();
        c.model.reset();
        return c;
    }
    c.build = (bench_now() - begin) / (double)c.tree.body.size();
    c.defect[0] = difference(c.model->accelerations(), c.tree.qdd) / largest(c.tree.qdd);
    if (library::has_inverse) c.defect[1] = inverse_defect(*c.model, c.tree);
    for (int which = 0; which < 2; ++which) {
        double once = std::min(time_call(c, which), time_call(c, which));
        if (!library::has_inverse && which == 1) continue;
        c.repeats[which] = 1 + (int)(sample_time / once);
    }
    return c;
}

/* What time_call is asked for: a tree and a call. */
struct job {
    candidate *c;
    int which;
};

double measure(void *jobs, int number)
{
    const job &j = static_cast<job *>(jobs)[number];
    return time_call(*j.c, j.which);
}

void report(const job &j, int samples, double *sample)
{
    static const char *const call_name[] = {"forward", "inverse"};
    const double per_body = 1e9 / (double)j.c->tree.body.size();
    const bench_quartiles s = bench_statistics(samples, sample);
    printf("%s,%zu,%s,%.2g,%.2f,,%.1f,%.1f,%.1f\n", j.c->tree.name.c_str(), j.c->tree.body.size(),
           call_name[j.which], j.c->defect[j.which], 1e6 * j.c->build, per_body * s.min,
           per_body * s.median, per_body * s.q3);
}

} // namespace

int main(int argc, char **argv)
{
    const int samples = argc > 2 ? std::atoi(argv[2]) : 21;
    if (argc < 2 || samples < 1) {
        fprintf(stderr, "usage: peer_%s folder [samples]\n", library::name);
        return 2;
    }
    std::vector<candidate> list;
    for (const char *name : trees) list.push_back(open_candidate(argv[1], name));
    printf("# %s %s: %s\n", library::name, library::version().c_str(), library::timed);
    std::vector<job> jobs;
    for (candidate &c : list) {
        if (!c.model)
            printf("# %s: %s refused: %s\n", library::name, c.tree.name.c_str(),
                   c.refusal.substr(0, c.refusal.find('\n')).c_str());
        for (int which = 0; c.model && which < (library::has_inverse ? 2 : 1); ++which) {
            if (c.defect[which] <= largest_defect)
                jobs.push_back({&c, which});
            else
                printf("# %s: %s, %s: wrong by %.2g of the largest number, not timed\n",
                       library::name, c.tree.name.c_str(), which ? "inverse" : "forward",
                       c.defect[which]);
        }
    }
    printf("tree,bodies,call,defect,build_us,data_bytes,min_ns,median_ns,q3_ns\n");
    std::vector<double> sample(jobs.size() * (size_t)samples);
    bench_sample_all((int)jobs.size(), samples, measure, jobs.data(), sample.data());
    for (size_t k = 0; k < jobs.size(); ++k) report(jobs[k], samples, &sample[k * (size_t)samples]);
    return 0;
}
