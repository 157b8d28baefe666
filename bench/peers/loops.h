/* What the programs that time other libraries on closed loops share: mechanisms from files, checks,
 * timing.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Mechanisms are rods in the plane, as `bench_loops --write` writes them. A program defines the
 * functions of `namespace library`; loops.cpp has the rest. */
#ifndef PEERS_LOOPS_H
#define PEERS_LOOPS_H

#include <memory>
#include <string>
#include <vector>

/* A uniform rod along its x, on a hinge about z; gravity is along -y. */
struct loops_rod {
    int parent;                   /* -1: the world */
    double x, y;                  /* the hinge, in the parent's axes */
    double angle, acceleration;   /* of the hinge, at rest */
    double mass, length, inertia; /* inertia: about its centre */
};

/* Ties points on the x of two rods; b -1: the world. */
struct loops_pin {
    int a, b;
    double on_a, on_b;
};

struct loops_mechanism {
    std::string name;
    std::vector<loops_rod> rod;
    std::vector<loops_pin> pin;
};

/* A mechanism in the library that is timed, at rest where it starts. */
class loops_model
{
  public:
    virtual ~loops_model() = default;
    /* Works through everything that depends on the state anew. */
    virtual void forward() = 0;
    virtual double acceleration(int rod) const = 0; /* of its hinge, of the last forward */
    /* The same at other angles and rates of the hinges; may make use of what was found last. */
    virtual void forward_at(const std::vector<double> &angle, const std::vector<double> &rate) = 0;
};

namespace library
{
extern const char *const name, *const timed;
extern const double largest_defect; /* of what may be timed, relative */
std::string version();
/* For a run in steps of `step` s. Throws a std::exception where the library refuses the mechanism.
 */
std::unique_ptr<loops_model> open(const loops_mechanism &mechanism, double step);
} // namespace library

#endif
