/* Trees in MuJoCo (composite rigid bodies, factor of the mass matrix).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "mujoco_files.h"
#include "peer.h"

namespace
{

/* The model's description: one element in the other. Principal axes are computed here, as those
 * that MuJoCo computes are good for 8 digits only. */
class writer
{
  public:
    explicit writer(const peer_tree &tree) : tree(tree), successors(tree.body.size() + 1)
    {
        for (size_t k = 0; k < tree.body.size(); ++k)
            successors[(size_t)(tree.body[k].parent + 1)].push_back(k);
        file.text.push_back("<mujoco><compiler angle=\"radian\" inertiafromgeom=\"false\"/>"
                            "<option gravity=\"0 0 -9.81\"><flag constraint=\"disable\" "
                            "contact=\"disable\"/></option><worldbody>");
        inside(-1, 0, 0);
        file.text[0] += "</worldbody></mujoco>";
    }

    mujoco_files file;

  private:
    void inertia(size_t to, const peer_body &b)
    {
        const peer_axes axes = peer_principal(b);
        std::array<double, 4> quaternion;
        mju_mat2Quat(quaternion.data(), axes.R[0]);
        file.text[to] += "<inertial";
        file.attribute(to, "pos", b.com);
        file.attribute(to, "mass", std::array<double, 1>{b.mass});
        file.attribute(to, "quat", quaternion);
        file.attribute(to, "diaginertia", axes.moments);
        file.text[to] += "/>";
    }

    void inside(int parent, size_t to, int level)
    {
        const bool deep = level == mujoco_files::LEVELS;
        if (deep) {
            to = file.include(to);
            level = 0;
        }
        for (size_t k : successors[(size_t)(parent + 1)]) {
            const peer_body &b = tree.body[k];
            file.text[to] += "<body name=\"" + std::to_string(k) + "\"";
            file.attribute(to, "pos", b.place);
            file.attribute(to, "quat", b.turn);
            file.text[to] += ">";
            inertia(to, b);
            if (b.type == 'F') {
                file.text[to] += "<freejoint/>";
            } else {
                file.text[to] += "<joint type=\"hinge\"";
                file.attribute(to, "axis", b.axis);
                file.text[to] += "/>";
            }
            inside((int)k, to, level + 1);
            file.text[to] += "</body>";
        }
        if (deep) file.text[to] += "</mujoco>";
    }

    const peer_tree &tree;
    std::vector<std::vector<size_t>> successors;
};

/* MuJoCo's angular velocity and moment of a free body are along its own axes. */
void to_body(const double *quaternion, double *x)
{
    double back[4], y[3];
    mju_negQuat(back, quaternion);
    mju_rotVecQuat(y, x, back);
    std::memcpy(x, y, sizeof y);
}

class model : public peer_model
{
  public:
    explicit model(const peer_tree &tree) : tree(tree)
    {
        m = writer(tree).file.load();
        d = mj_makeData(m);
        place();
        mj_forward(m, d);
    }

    ~model() override
    {
        mj_deleteData(d);
        mj_deleteModel(m);
    }

    void forward() override
    {
        mj_kinematics(m, d);
        mj_comPos(m, d);
        mj_crb(m, d);
        mj_factorM(m, d);
        mj_fwdVelocity(m, d);
        mj_fwdActuation(m, d);
        mj_fwdAcceleration(m, d);
    }

    std::vector<double> accelerations() const override
    {
        return to_file(d->qacc_smooth);
    }

    void inverse() override
    {
        mj_kinematics(m, d);
        mj_comPos(m, d);
        mj_comVel(m, d);
        mj_rne(m, d, 1, force.data());
    }

    void accelerate(const std::vector<double> &qdd) override
    {
        for (size_t k = 0; k < from.size(); ++k) d->qacc[from[k]] = qdd[k];
        if (tree.free_root) to_body(&tree.q[3], d->qacc + from[3]);
    }

    std::vector<double> joint_forces() const override
    {
        return to_file(force.data());
    }

  private:
    /* Bodies stand in depth-first order in the model; the file's numbers are their names. */
    void place()
    {
        force.resize((size_t)m->nv);
        const int more_q = tree.free_root ? 6 : 0, more_v = tree.free_root ? 5 : 0;
        for (size_t k = 0; k < tree.body.size(); ++k) {
            const int body = mj_name2id(m, mjOBJ_BODY, std::to_string(k).c_str());
            const int joint = m->body_jntadr[body], n = m->body_dofnum[body],
                      nq = tree.body[k].type == 'F' ? 7 : 1;
            const size_t q = k + (size_t)(k > 0 ? more_q : 0), v = k + (size_t)(k > 0 ? more_v : 0);
            double *own = d->qvel + m->jnt_dofadr[joint], *tau = d->qfrc_applied + (own - d->qvel);
            std::memcpy(d->qpos + m->jnt_qposadr[joint], &tree.q[q], (size_t)nq * sizeof(double));
            std::memcpy(own, &tree.v[v], (size_t)n * sizeof(double));
            std::memcpy(tau, &tree.tau[v], (size_t)n * sizeof(double));
            for (int l = 0; l < n; ++l) from.push_back((int)(own - d->qvel) + l);
            if (n != 6) continue;
            to_body(&tree.q[3], own + 3);
            to_body(&tree.q[3], tau + 3);
        }
    }

    std::vector<double> to_file(const double *x) const
    {
        std::vector<double> y;
        for (int place : from) y.push_back(x[place]);
        if (tree.free_root) mju_rotVecQuat(&y[3], x + from[3], &tree.q[3]);
        return y;
    }

    const peer_tree &tree;
    mjModel *m = nullptr;
    mjData *d = nullptr;
    std::vector<int> from; /* the file's k-th velocity in the model */
    std::vector<double> force;
};

void raise(const char *message)
{
    throw std::runtime_error(message);
}

} // namespace

namespace library
{
const char *const name = "mujoco";
const char *const timed =
    "forward = mj_kinematics, mj_comPos, mj_crb, mj_factorM, mj_fwdVelocity, mj_fwdActuation, "
    "mj_fwdAcceleration, constraints and contacts disabled; inverse = mj_kinematics, mj_comPos, "
    "mj_comVel, mj_rne";
const bool has_inverse = true;

std::string version()
{
    return mj_versionString();
}

std::unique_ptr<peer_model> open(const peer_tree &tree)
{
    mju_user_error = raise;
    return std::make_unique<model>(tree);
}
} // namespace library
