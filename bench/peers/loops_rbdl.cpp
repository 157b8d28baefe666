/* Closed loops in RBDL: constraint sets.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <rbdl/rbdl.h>

namespace
{

namespace rb = RigidBodyDynamics;
using rb::Math::Matrix3d;
using rb::Math::SpatialVector;
using rb::Math::Vector3d;
using rb::Math::VectorNd;

class model : public loops_model
{
  public:
    explicit model(const loops_mechanism &m)
    {
        rbdl.gravity = Vector3d(0.0, -9.81, 0.0);
        for (const loops_rod &r : m.rod) {
            Matrix3d tensor = Matrix3d::Zero();
            tensor(1, 1) = tensor(2, 2) = r.inertia;
            const rb::Body body(r.mass, Vector3d(0.5 * r.length, 0.0, 0.0), tensor);
            number.push_back(rbdl.AddBody(number_of(r.parent), rb::Math::Xtrans({r.x, r.y, 0.0}),
                                          rb::Joint(rb::JointTypeRevoluteZ), body));
        }
        for (const loops_pin &p : m.pin) {
            for (int axis = 3; axis < 5; ++axis) {
                SpatialVector along = SpatialVector::Zero();
                along[axis] = 1.0;
                set.AddLoopConstraint(number_of(p.a), number_of(p.b),
                                      rb::Math::Xtrans({p.on_a, 0.0, 0.0}),
                                      rb::Math::Xtrans({p.on_b, 0.0, 0.0}), along);
            }
        }
        set.Bind(rbdl);
        q = v = tau = qdd = VectorNd::Zero((long)m.rod.size());
        for (size_t k = 0; k < m.rod.size(); ++k) q[(long)k] = m.rod[k].angle;
    }

    void forward() override
    {
        rb::ForwardDynamicsConstraintsRangeSpaceSparse(rbdl, q, v, tau, set, qdd);
    }

    void forward_at(const std::vector<double> &angle, const std::vector<double> &rate) override
    {
        q = Eigen::Map<const Eigen::VectorXd>(angle.data(), q.size());
        v = Eigen::Map<const Eigen::VectorXd>(rate.data(), v.size());
        forward();
    }

    double acceleration(int rod) const override
    {
        return qdd[rod];
    }

  private:
    unsigned number_of(int rod) const
    {
        return rod < 0 ? 0 : number[(size_t)rod];
    }

    std::vector<unsigned> number;
    rb::Model rbdl;
    rb::ConstraintSet set;
    VectorNd q, v, tau, qdd;
};

} // namespace

namespace library
{
const char *const name = "rbdl";
const char *const timed = "ForwardDynamicsConstraintsRangeSpaceSparse, two loop constraints a pin";
const double largest_defect = 1e-7;

std::string version()
{
    const int v = rbdl_get_api_version();
    return std::to_string(v >> 16 & 255) + "." + std::to_string(v >> 8 & 255) + "." +
           std::to_string(v & 255);
}

std::unique_ptr<loops_model> open(const loops_mechanism &m, double)
{
    return std::make_unique<model>(m);
}
} // namespace library
