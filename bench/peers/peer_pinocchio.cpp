/* Trees in Pinocchio.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <pinocchio/fwd.hpp>

#include "peer.h"

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include <Eigen/Geometry>

#include <stdexcept>

namespace
{

namespace pin = pinocchio;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d vector(const std::array<double, 3> &x)
{
    return Vector3d(x[0], x[1], x[2]);
}

/* From w, x, y, z. */
Matrix3d rotation(const double *q)
{
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

/* Joints about z have code of their own, so z is put along every axis. */
Matrix3d along(const peer_body &b)
{
    if (b.type == 'F') return Matrix3d::Identity();
    return Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), vector(b.axis)).toRotationMatrix();
}

pin::Inertia inertia_of(const peer_body &b, const Matrix3d &axes)
{
    const auto &I = b.inertia;
    Matrix3d tensor;
    tensor << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
    return pin::Inertia(b.mass, axes.transpose() * vector(b.com), axes.transpose() * tensor * axes);
}

/* Velocities of a free root are along its own axes. */
class model : public peer_model
{
  public:
    explicit model(const peer_tree &tree) : free(tree.free_root), own(make(tree)), data(own)
    {
        q = pin::neutral(own);
        const long first = free ? 7 : 0;
        if (free) {
            root = rotation(&tree.q[3]);
            q.head(7) << tree.q[0], tree.q[1], tree.q[2], tree.q[4], tree.q[5], tree.q[6],
                tree.q[3];
        }
        for (long k = first; k < (long)tree.q.size(); ++k) q[k] = tree.q[(size_t)k];
        v = turned(tree.v);
        tau = turned(tree.tau);
    }

    void forward() override
    {
        pin::aba(own, data, q, v, tau, pin::Convention::LOCAL);
    }

    std::vector<double> accelerations() const override
    {
        VectorXd a = data.ddq;
        if (free) a.head(3) += Vector3d(v.segment(3, 3)).cross(Vector3d(v.head(3)));
        return back(a);
    }

    void accelerate(const std::vector<double> &x) override
    {
        given = turned(x);
        if (free) given.head(3) -= Vector3d(v.segment(3, 3)).cross(Vector3d(v.head(3)));
    }

    void inverse() override
    {
        pin::rnea(own, data, q, v, given);
    }

    std::vector<double> joint_forces() const override
    {
        return back(data.tau);
    }

  private:
    static pin::Model make(const peer_tree &tree)
    {
        pin::Model m;
        const double nv = (double)tree.v.size();
        if (32.0 * nv * nv * nv > 2e9)
            throw std::runtime_error("its Data has four arrays of nv x nv x nv numbers");
        std::vector<pin::JointIndex> number;
        std::vector<Matrix3d> frame;
        m.gravity.linear(Vector3d(0.0, 0.0, -9.81));
        for (const peer_body &b : tree.body) {
            const bool first = b.parent < 0;
            const Matrix3d axes = along(b), before = first ? Matrix3d(Matrix3d::Identity())
                                                           : frame[(size_t)b.parent];
            const pin::SE3 place(before.transpose() * rotation(b.turn.data()) * axes,
                                 before.transpose() * vector(b.place));
            const pin::JointIndex parent = first ? 0 : number[(size_t)b.parent];
            const std::string name = "joint" + std::to_string(number.size());
            const pin::JointIndex joint =
                b.type == 'F' ? m.addJoint(parent, pin::JointModelFreeFlyer(), place, name)
                              : m.addJoint(parent, pin::JointModelRZ(), place, name);
            m.appendBodyToJoint(joint, inertia_of(b, axes), pin::SE3::Identity());
            number.push_back(joint);
            frame.push_back(axes);
        }
        return m;
    }

    VectorXd turned(const std::vector<double> &x) const
    {
        VectorXd y = Eigen::Map<const VectorXd>(x.data(), (long)x.size());
        for (long k = 0; free && k < 6; k += 3)
            y.segment(k, 3) = root.transpose() * Vector3d(y.segment(k, 3));
        return y;
    }

    std::vector<double> back(VectorXd y) const
    {
        for (long k = 0; free && k < 6; k += 3) y.segment(k, 3) = root * Vector3d(y.segment(k, 3));
        return std::vector<double>(y.data(), y.data() + y.size());
    }

    bool free;
    Matrix3d root = Matrix3d::Identity();
    pin::Model own;
    pin::Data data;
    VectorXd q, v, tau, given;
};

} // namespace

namespace library
{
const char *const name = "pinocchio";
const char *const timed = "forward = aba; inverse = rnea; joints about z";
const bool has_inverse = true;

std::string version()
{
    return PINOCCHIO_VERSION;
}

std::unique_ptr<peer_model> open(const peer_tree &tree)
{
    return std::make_unique<model>(tree);
}
} // namespace library
