/* Trees in Simbody (articulated bodies).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "peer.h"

#include <Simbody.h>

#include <map>

namespace
{

using SimTK::Vec3;

Vec3 vector(const std::array<double, 3> &x)
{
    return Vec3(x[0], x[1], x[2]);
}

SimTK::MassProperties mass_of(const peer_body &b)
{
    const auto &I = b.inertia;
    const SimTK::Inertia central(Vec3(I[0], I[1], I[2]), Vec3(I[3], I[4], I[5]));
    return SimTK::MassProperties(b.mass, vector(b.com),
                                 central.shiftFromMassCenter(vector(b.com), b.mass));
}

class model : public peer_model
{
  public:
    explicit model(const peer_tree &tree)
        : tree(tree), matter(system), forces(system), gravity(forces, matter, Vec3(0, 0, -9.81)),
          discrete(forces, matter)
    {
        for (const peer_body &b : tree.body) {
            SimTK::MobilizedBody &parent =
                b.parent < 0 ? matter.Ground() : matter.updMobilizedBody(number[(size_t)b.parent]);
            number.push_back(add(parent, b));
        }
        state = system.realizeTopology();
        matter.setUseEulerAngles(state, false);
        system.realizeModel(state);
        place();
    }

    void forward() override
    {
        state.updQ();
        state.updU();
        system.realize(state, SimTK::Stage::Acceleration);
    }

    std::vector<double> accelerations() const override
    {
        return to_file(state.getUDot());
    }

    void inverse() override
    {
        state.updQ();
        state.updU();
        system.realize(state, SimTK::Stage::Velocity);
        matter.calcResidualForceIgnoringConstraints(state, none, gravity.getBodyForces(state),
                                                    given, force);
    }

    void accelerate(const std::vector<double> &qdd) override
    {
        for (size_t k = 0; k < u_of.size(); ++k) given[u_of[k]] = qdd[k];
    }

    std::vector<double> joint_forces() const override
    {
        return to_file(force);
    }

  private:
    /* A pin turns about z: frames on both sides have it along the joint's axis. */
    static SimTK::MobilizedBodyIndex add(SimTK::MobilizedBody &parent, const peer_body &b)
    {
        if (b.type == 'F') return SimTK::MobilizedBody::Free(parent, mass_of(b));
        const SimTK::Rotation along(SimTK::UnitVec3(vector(b.axis)), SimTK::ZAxis);
        const SimTK::Quaternion turn(b.turn[0], b.turn[1], b.turn[2], b.turn[3]);
        return SimTK::MobilizedBody::Pin(
            parent, SimTK::Transform(SimTK::Rotation(turn) * along, vector(b.place)), mass_of(b),
            SimTK::Transform(along));
    }

    /* Places of the file's k-th coordinate and velocity; a free body has rotation first here. */
    void place()
    {
        for (size_t k = 0; k < number.size(); ++k) {
            const SimTK::MobilizedBody &body = matter.getMobilizedBody(number[k]);
            const int q = body.getFirstQIndex(state), u = body.getFirstUIndex(state);
            const bool free = tree.body[k].type == 'F';
            for (int l = 0; l < (free ? 7 : 1); ++l) q_of.push_back(q + (free ? (l + 4) % 7 : 0));
            for (int l = 0; l < (free ? 6 : 1); ++l) u_of.push_back(u + (free ? (l + 3) % 6 : 0));
        }
        SimTK::Vector tau(state.getNU());
        given.resize(state.getNU());
        none.resize(state.getNU());
        none = 0;
        for (size_t k = 0; k < q_of.size(); ++k) state.updQ()[q_of[k]] = tree.q[k];
        for (size_t k = 0; k < u_of.size(); ++k) {
            state.updU()[u_of[k]] = tree.v[k];
            tau[u_of[k]] = tree.tau[k];
        }
        system.realize(state, SimTK::Stage::Velocity);
        discrete.setAllMobilityForces(state, tau);
    }

    std::vector<double> to_file(const SimTK::Vector &x) const
    {
        std::vector<double> y;
        for (int place : u_of) y.push_back(x[place]);
        return y;
    }

    const peer_tree &tree;
    SimTK::MultibodySystem system;
    SimTK::SimbodyMatterSubsystem matter;
    SimTK::GeneralForceSubsystem forces;
    SimTK::Force::Gravity gravity;
    SimTK::Force::DiscreteForces discrete;
    SimTK::State state;
    std::vector<SimTK::MobilizedBodyIndex> number;
    std::vector<int> q_of, u_of;
    SimTK::Vector given, none, force;
};

} // namespace

namespace library
{
const char *const name = "simbody";
const char *const timed =
    "forward = realize(Acceleration) after q and u have changed; inverse = realize(Velocity) after "
    "the same and calcResidualForceIgnoringConstraints";
const bool has_inverse = true;

std::string version()
{
    int major, minor, build;
    SimTK_version_simbody(&major, &minor, &build);
    return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(build);
}

std::unique_ptr<peer_model> open(const peer_tree &tree)
{
    return std::make_unique<model>(tree);
}
} // namespace library
