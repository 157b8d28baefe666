/* Trees in RBDL (Featherstone's algorithms).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "peer.h"

#include <rbdl/rbdl.h>

#include <Eigen/Geometry>

namespace
{

namespace rb = RigidBodyDynamics;
using rb::Math::Matrix3d;
using rb::Math::Vector3d;
using rb::Math::VectorNd;

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

rb::Body body_of(const peer_body &b, const Matrix3d &axes)
{
    const auto &I = b.inertia;
    Matrix3d tensor;
    tensor << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
    const Vector3d com = axes.transpose() * vector(b.com);
    const Matrix3d turned = axes.transpose() * tensor * axes;
    return rb::Body(b.mass, com, turned);
}

/* Of a free root, velocities are along the world's axes, angular ones along the body's. */
class model : public peer_model
{
  public:
    explicit model(const peer_tree &tree) : free(tree.free_root)
    {
        std::vector<unsigned> number;
        std::vector<Matrix3d> frame;
        rbdl.gravity = Vector3d(0.0, 0.0, -9.81);
        for (const peer_body &b : tree.body) {
            const Matrix3d axes = along(b),
                           before = b.parent < 0 ? Matrix3d(Matrix3d::Identity())
                                                 : frame[(size_t)b.parent],
                           R = before.transpose() * rotation(b.turn.data()) * axes;
            const rb::Math::SpatialTransform place(R.transpose(),
                                                   before.transpose() * vector(b.place));
            const rb::Joint joint(b.type == 'F' ? rb::JointTypeFloatingBase
                                                : rb::JointTypeRevoluteZ);
            number.push_back(rbdl.AddBody(b.parent < 0 ? 0 : number[(size_t)b.parent], place, joint,
                                          body_of(b, axes)));
            frame.push_back(axes);
        }
        q = VectorNd::Zero(rbdl.q_size);
        v = tau = qdd = given = force = VectorNd::Zero(rbdl.qdot_size);
        set(tree.v, v);
        const size_t first = free ? 7 : 0;
        if (free) {
            root = rotation(&tree.q[3]);
            q.head(3) = Eigen::Map<const Eigen::Vector3d>(tree.q.data());
            rbdl.SetQuaternion(number[0], rb::Math::Quaternion::fromMatrix(root.transpose()), q);
            set(tree.v, v);
        }
        for (size_t k = first; k < tree.q.size(); ++k)
            q[(long)(k - first) + (free ? 6 : 0)] = tree.q[k];
        set(tree.tau, tau);
    }

    void forward() override
    {
        rb::ForwardDynamics(rbdl, q, v, tau, qdd);
    }

    std::vector<double> accelerations() const override
    {
        return get(qdd);
    }

    void accelerate(const std::vector<double> &x) override
    {
        set(x, given);
    }

    void inverse() override
    {
        rb::InverseDynamics(rbdl, q, v, given, force);
    }

    std::vector<double> joint_forces() const override
    {
        return get(force);
    }

  private:
    void set(const std::vector<double> &x, VectorNd &y) const
    {
        y = Eigen::Map<const Eigen::VectorXd>(x.data(), (long)x.size());
        if (free) y.segment(3, 3) = root.transpose() * Vector3d(y.segment(3, 3));
    }

    std::vector<double> get(VectorNd y) const
    {
        if (free) y.segment(3, 3) = root * Vector3d(y.segment(3, 3));
        return std::vector<double>(y.data(), y.data() + y.size());
    }

    bool free;
    Matrix3d root = Matrix3d::Identity();
    rb::Model rbdl;
    VectorNd q, v, tau, qdd, given, force;
};

} // namespace

namespace library
{
const char *const name = "rbdl";
const char *const timed = "forward = ForwardDynamics; inverse = InverseDynamics; joints about z";
const bool has_inverse = true;

std::string version()
{
    const int v = rbdl_get_api_version();
    return std::to_string(v >> 16 & 255) + "." + std::to_string(v >> 8 & 255) + "." +
           std::to_string(v & 255);
}

std::unique_ptr<peer_model> open(const peer_tree &tree)
{
    return std::make_unique<model>(tree);
}
} // namespace library
