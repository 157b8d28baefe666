/* What the programs that time other libraries share: trees from files, checks, timing.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The trees and the order of their numbers are those of tests/reference/trees/README.md. A program
 * defines the functions of `namespace library`; peer.cpp has the rest. */
#ifndef PEER_H
#define PEER_H

#include <array>
#include <memory>
#include <string>
#include <vector>

struct peer_body {
    int parent; /* -1: the world */
    char type;  /* R revolute, F free */
    std::array<double, 3> axis, place, com;
    std::array<double, 4> turn; /* w, x, y, z */
    double mass;
    std::array<double, 6> inertia; /* xx yy zz xy xz yz, about the centre of mass */
};

/* Principal axes (columns of a rotation) and moments of a body's tensor. */
struct peer_axes {
    double R[3][3];
    std::array<double, 3> moments;
};

peer_axes peer_principal(const peer_body &b);

struct peer_tree {
    std::string name;
    bool free_root;
    std::vector<peer_body> body;
    std::vector<double> q, v, tau, qdd; /* free root first: linear, then angular */
};

/* A tree in the library that is timed. Both calls work through everything that depends on q and v
 * anew; the state and the joint forces are those of the tree. */
class peer_model
{
  public:
    virtual ~peer_model() = default;
    virtual void forward() = 0;
    virtual std::vector<double> accelerations() const = 0; /* of the last forward, file's order */
    /* From the accelerations set last, in the file's order, to joint forces. */
    virtual void accelerate(const std::vector<double> &)
    {
    }
    virtual void inverse()
    {
    }
    virtual std::vector<double> joint_forces() const
    {
        return {};
    } /* of the last inverse */
};

namespace library
{
extern const char *const name, *const timed;
extern const bool has_inverse;
std::string version();
/* Throws a std::exception where the library refuses the tree. */
std::unique_ptr<peer_model> open(const peer_tree &tree);
} // namespace library

#endif
