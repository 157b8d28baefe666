/* Trees in Bullet (btMultiBody: articulated bodies), in double precision. Its inverse dynamics is
 * in a library of its own, which Debian does not have.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "peer.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>

namespace
{

btVector3 vector(const std::array<double, 3> &x)
{
    return btVector3(x[0], x[1], x[2]);
}

btVector3 vector(const double *x)
{
    return btVector3(x[0], x[1], x[2]);
}

/* A link's frame is in its centre of mass, along its principal axes. */
struct link {
    btMatrix3x3 axes; /* in the body's frame */
    btVector3 moments, com;
};

link principal(const peer_body &b)
{
    const peer_axes a = peer_principal(b);
    link l;
    for (int k = 0; k < 3; ++k) l.axes[k] = vector(a.R[k]);
    l.moments = vector(a.moments);
    l.com = vector(b.com);
    return l;
}

btQuaternion quaternion(const btMatrix3x3 &R)
{
    btQuaternion q;
    R.getRotation(q);
    return q;
}

class model : public peer_model
{
  public:
    explicit model(const peer_tree &tree) : tree(tree)
    {
        const int links = (int)tree.body.size() - tree.free_root;
        for (const peer_body &b : tree.body) list.push_back(principal(b));
        const link world{btMatrix3x3::getIdentity(), btVector3(0, 0, 0), btVector3(0, 0, 0)},
            base = tree.free_root ? list[0] : world;
        multibody = std::make_unique<btMultiBody>(links, tree.free_root ? tree.body[0].mass : 0.0,
                                                  base.moments, !tree.free_root, false);
        for (int k = 0; k < links; ++k) {
            const peer_body &b = tree.body[(size_t)(k + tree.free_root)];
            const link &own = list[(size_t)(k + tree.free_root)],
                       &parent = b.parent < 0 ? world : list[(size_t)b.parent];
            const btMatrix3x3 joint(btQuaternion(b.turn[1], b.turn[2], b.turn[3], b.turn[0])),
                rest = parent.axes.transpose() * joint * own.axes;
            multibody->setupRevolute(k, b.mass, own.moments, b.parent - tree.free_root,
                                     quaternion(rest.transpose()),
                                     own.axes.transpose() * vector(b.axis),
                                     parent.axes.transpose() * (vector(b.place) - parent.com),
                                     own.axes.transpose() * own.com);
        }
        multibody->finalizeMultiDof();
        multibody->setLinearDamping(0);
        multibody->setAngularDamping(0);
        multibody->setUseGyroTerm(true);
        place();
    }

    void forward() override
    {
        const int links = multibody->getNumLinks();
        for (int k = 0; k < links; ++k) multibody->setJointPos(k, joint_q[k]);
        multibody->computeAccelerationsArticulatedBodyAlgorithmMultiDof(0.0, r, v, m, false, false,
                                                                        false);
    }

    /* The library leaves them in its scratch array, the base's first: angular, linear, of its
     * centre of mass. */
    std::vector<double> accelerations() const override
    {
        const btScalar *x = &r[multibody->getNumDofs()];
        std::vector<double> y;
        if (tree.free_root) {
            const btVector3 c = base_axes() * list[0].com, alpha = vector(x),
                            omega = vector(&tree.v[3]),
                            a = vector(x + 3) - alpha.cross(c) - omega.cross(omega.cross(c));
            for (int k = 0; k < 3; ++k) y.push_back(a[k]);
            for (int k = 0; k < 3; ++k) y.push_back(alpha[k]);
        }
        y.insert(y.end(), x + 6, x + 6 + multibody->getNumLinks());
        return y;
    }

  private:
    btMatrix3x3 base_axes() const
    {
        return btMatrix3x3(btQuaternion(tree.q[4], tree.q[5], tree.q[6], tree.q[3]));
    }

    void place()
    {
        const btVector3 gravity(0, 0, -9.81);
        const int links = multibody->getNumLinks();
        const size_t first_q = tree.free_root ? 7 : 0, first_v = tree.free_root ? 6 : 0;
        joint_q.assign(tree.q.begin() + (long)first_q, tree.q.end());
        for (int k = 0; k < links; ++k) {
            multibody->setJointVel(k, tree.v[first_v + (size_t)k]);
            multibody->addJointTorque(k, tree.tau[first_v + (size_t)k]);
            multibody->addLinkForce(k, gravity * multibody->getLinkMass(k));
        }
        if (!tree.free_root) return;
        const btMatrix3x3 R = base_axes();
        const btVector3 c = R * list[0].com, omega = vector(&tree.v[3]),
                        force = vector(&tree.tau[0]);
        multibody->setBasePos(vector(&tree.q[0]) + c);
        multibody->setWorldToBaseRot(quaternion((R * list[0].axes).transpose()));
        multibody->setBaseOmega(omega);
        multibody->setBaseVel(vector(&tree.v[0]) + omega.cross(c));
        multibody->addBaseForce(force + gravity * multibody->getBaseMass());
        multibody->addBaseTorque(vector(&tree.tau[3]) - c.cross(force));
    }

    const peer_tree &tree;
    std::vector<link> list;
    std::unique_ptr<btMultiBody> multibody;
    std::vector<double> joint_q;
    btAlignedObjectArray<btScalar> r;
    btAlignedObjectArray<btVector3> v;
    btAlignedObjectArray<btMatrix3x3> m;
};

} // namespace

namespace library
{
const char *const name = "bullet";
const char *const timed =
    "forward = setJointPos of all joints, computeAccelerationsArticulatedBodyAlgorithmMultiDof, "
    "double precision; no inverse dynamics in Debian's package";
const bool has_inverse = false;

std::string version()
{
    return std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
}

std::unique_ptr<peer_model> open(const peer_tree &tree)
{
    return std::make_unique<model>(tree);
}
} // namespace library
