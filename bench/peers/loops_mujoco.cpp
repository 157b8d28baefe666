/* Closed loops in MuJoCo: soft constraints, as hard as it takes them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "mujoco_files.h"

#include <array>
#include <cmath>

namespace
{

/* Drawn closed: anchors of constraints are taken from there. Constraints are pulled back within two
 * steps, the shortest time that MuJoCo allows. */
class writer
{
  public:
    writer(const loops_mechanism &m, double step) : m(m), successors(m.rod.size() + 1)
    {
        for (size_t k = 0; k < m.rod.size(); ++k)
            successors[(size_t)(m.rod[k].parent + 1)].push_back(k);
        file.text.push_back("<mujoco><compiler angle=\"radian\" inertiafromgeom=\"false\"/>"
                            "<size nstack=\"40000000\"/><option gravity=\"0 -9.81 0\" "
                            "tolerance=\"1e-12\"");
        file.attribute(0, "timestep", std::array<double, 1>{step});
        file.text[0] += "><flag contact=\"disable\"/></option><worldbody>";
        inside(-1, 0, 0);
        file.text[0] += "</worldbody><equality>";
        for (const loops_pin &p : m.pin) {
            file.text[0] += "<connect solimp=\"0.9999 0.9999 0.001 0.5 1\" body1=\"" +
                            std::to_string(p.a) + "\"";
            if (p.b >= 0) file.text[0] += " body2=\"" + std::to_string(p.b) + "\"";
            file.attribute(0, "solref", std::array<double, 2>{2.0 * step, 1.0});
            file.attribute(0, "anchor", std::array<double, 3>{p.on_a, 0.0, 0.0});
            file.text[0] += "/>";
        }
        file.text[0] += "</equality></mujoco>";
    }

    mujoco_files file;

  private:
    /* A moment about the rod itself moves nothing here, and must not be zero. */
    void rod(size_t to, const loops_rod &r)
    {
        file.attribute(to, "pos", std::array<double, 3>{r.x, r.y, 0.0});
        file.attribute(
            to, "quat",
            std::array<double, 4>{std::cos(0.5 * r.angle), 0.0, 0.0, std::sin(0.5 * r.angle)});
        file.text[to] += "><inertial";
        file.attribute(to, "pos", std::array<double, 3>{0.5 * r.length, 0.0, 0.0});
        file.attribute(to, "mass", std::array<double, 1>{r.mass});
        file.attribute(to, "diaginertia", std::array<double, 3>{r.inertia, r.inertia, r.inertia});
        file.text[to] += "/><joint type=\"hinge\" axis=\"0 0 1\"/>";
    }

    void inside(int parent, size_t to, int level)
    {
        const bool deep = level == mujoco_files::LEVELS;
        if (successors[(size_t)(parent + 1)].empty()) return;
        if (deep) {
            to = file.include(to);
            level = 0;
        }
        for (size_t k : successors[(size_t)(parent + 1)]) {
            file.text[to] += "<body name=\"" + std::to_string(k) + "\"";
            rod(to, m.rod[k]);
            inside((int)k, to, level + 1);
            file.text[to] += "</body>";
        }
        if (deep) file.text[to] += "</mujoco>";
    }

    const loops_mechanism &m;
    std::vector<std::vector<size_t>> successors;
};

class model : public loops_model
{
  public:
    model(const loops_mechanism &mechanism, double step) : start(mechanism.rod.size())
    {
        m = writer(mechanism, step).file.load();
        d = mj_makeData(m);
        for (size_t k = 0; k < mechanism.rod.size(); ++k)
            start[k] = mechanism.rod[k].angle,
            place.push_back(m->body_dofadr[mj_name2id(m, mjOBJ_BODY, std::to_string(k).c_str())]);
    }

    ~model() override
    {
        mj_deleteData(d);
        mj_deleteModel(m);
    }

    void forward() override
    {
        mju_zero(d->qacc_warmstart, m->nv);
        mj_forward(m, d);
    }

    void forward_at(const std::vector<double> &angle, const std::vector<double> &rate) override
    {
        for (size_t k = 0; k < place.size(); ++k) {
            d->qpos[place[k]] = angle[k] - start[k];
            d->qvel[place[k]] = rate[k];
        }
        mj_forward(m, d);
        mju_copy(d->qacc_warmstart, d->qacc, m->nv);
    }

    double acceleration(int rod) const override
    {
        return d->qacc[place[(size_t)rod]];
    }

  private:
    mjModel *m;
    mjData *d;
    std::vector<double> start;
    std::vector<int> place;
};

} // namespace

namespace library
{
const char *const name = "mujoco";
const char *const timed = "mj_forward from a cold start, impedance 0.9999: accelerations are soft";
const double largest_defect = 1e-1;

std::string version()
{
    return mj_versionString();
}

std::unique_ptr<loops_model> open(const loops_mechanism &m, double step)
{
    return std::make_unique<model>(m, step);
}
} // namespace library
