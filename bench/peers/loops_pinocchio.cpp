/* Closed loops in Pinocchio: constraintDynamics.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <pinocchio/fwd.hpp>

#include "loops.h"

#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <pinocchio/algorithm/contact-info.hpp>
#include <pinocchio/algorithm/proximal.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include <stdexcept>

namespace
{

namespace pin = pinocchio;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

pin::SE3 at(double x, double y)
{
    return pin::SE3(Matrix3d::Identity(), Vector3d(x, y, 0.0));
}

/* Pins have a third row, along z, which depends on the others: proximal iterations serve it. */
class model : public loops_model
{
  public:
    explicit model(const loops_mechanism &m) : own(make(m)), data(own), settings(1e-12, 1e-10, 20)
    {
        for (const loops_pin &p : m.pin)
            constraint.emplace_back(pin::CONTACT_3D, own, (pin::JointIndex)(p.a + 1),
                                    at(p.on_a, 0.0), (pin::JointIndex)(p.b + 1), at(p.on_b, 0.0),
                                    pin::LOCAL);
        for (const pin::RigidConstraintModel &c : constraint) of_constraint.emplace_back(c);
        pin::initConstraintDynamics(own, data, constraint);
        q = v = tau = VectorXd::Zero((long)m.rod.size());
        for (size_t k = 0; k < m.rod.size(); ++k) q[(long)k] = m.rod[k].angle;
    }

    void forward() override
    {
        pin::constraintDynamics(own, data, q, v, tau, constraint, of_constraint, settings);
    }

    void forward_at(const std::vector<double> &angle, const std::vector<double> &rate) override
    {
        q = Eigen::Map<const VectorXd>(angle.data(), q.size());
        v = Eigen::Map<const VectorXd>(rate.data(), v.size());
        forward();
    }

    double acceleration(int rod) const override
    {
        return data.ddq[rod];
    }

  private:
    static pin::Model make(const loops_mechanism &m)
    {
        pin::Model made;
        const double nv = (double)m.rod.size();
        if (32.0 * nv * nv * nv > 2.5e9)
            throw std::runtime_error("its Data has four arrays of nv x nv x nv numbers");
        made.gravity.linear(Vector3d(0.0, -9.81, 0.0));
        for (const loops_rod &r : m.rod) {
            const pin::JointIndex joint =
                made.addJoint((pin::JointIndex)(r.parent + 1), pin::JointModelRZ(), at(r.x, r.y),
                              "joint" + std::to_string(made.njoints));
            const Matrix3d tensor = Vector3d(0.0, r.inertia, r.inertia).asDiagonal();
            made.appendBodyToJoint(joint,
                                   pin::Inertia(r.mass, Vector3d(0.5 * r.length, 0.0, 0.0), tensor),
                                   pin::SE3::Identity());
        }
        return made;
    }

    pin::Model own;
    pin::Data data;
    std::vector<pin::RigidConstraintModel, Eigen::aligned_allocator<pin::RigidConstraintModel>>
        constraint;
    std::vector<pin::RigidConstraintData, Eigen::aligned_allocator<pin::RigidConstraintData>>
        of_constraint;
    pin::ProximalSettings settings;
    VectorXd q, v, tau;
};

} // namespace

namespace library
{
const char *const name = "pinocchio";
const char *const timed = "constraintDynamics, CONTACT_3D, proximal with mu = 1e-10";
const double largest_defect = 1e-7;

std::string version()
{
    return PINOCCHIO_VERSION;
}

std::unique_ptr<loops_model> open(const loops_mechanism &m, double)
{
    return std::make_unique<model>(m);
}
} // namespace library
