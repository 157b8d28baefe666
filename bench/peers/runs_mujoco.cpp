/* Whole runs of stiff trees (runs/stiff.h) in MuJoCo: with its integrator `implicit`, implicit in
 * all velocities, and with `Euler`, implicit in the velocities at the dampers in joints.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   runs_mujoco folder [seconds]     CSV on standard output, columns as those of bench_newton
 *
 * The folder has the files that bench_newton left there: where the bodies are at the end, and the
 * error to compare with. Each model runs with steps of 16 ms, 8 ms and so on until its error is
 * no larger than that. What has no mass, or no moment of inertia, gets 1e-12 of what is usual in
 * the model, or as much more, by factors of 1000, as it takes with that step. Runs that do
 * not end well, because the step is too long for the springs, are not shown. A run that would take
 * more than `seconds` is left out: what it would take is in its line, from the time of its first
 * steps. */
#include "mujoco_files.h"
#include "stiff.h"

extern "C" {
#include "bench.h"
}

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>

namespace
{

using vector3 = std::array<double, 3>;

vector3 vector(const double *x)
{
    return {x[0], x[1], x[2]};
}

/* ---- description ------------------------------------------------------------------------------
 * */

/* Bodies without mass get `share` of the model's usual mass and moment; the moments of others are
 * at least that. */
class writer
{
  public:
    writer(const stiff_model &s, const char *integrator, double step, double share)
        : s(s), share(share), successors((size_t)s.bodies + 1), sites((size_t)s.bodies)
    {
        for (int k = 0; k < s.bodies; ++k) successors[(size_t)(s.body[k].parent + 1)].push_back(k);
        file.text.push_back("<mujoco><compiler angle=\"radian\" inertiafromgeom=\"false\"/>"
                            "<size nstack=\"40000000\"/><option integrator=\"" +
                            std::string(integrator) + "\"");
        file.attribute(0, "timestep", std::array<double, 1>{step});
        file.attribute(0, "gravity", vector(s.gravity));
        file.text[0] += "><flag constraint=\"disable\" contact=\"disable\"/></option>";
        place_sites();
        file.text[0] += "<worldbody>";
        inside(STIFF_GROUND, 0, 0);
        file.text[0] += "</worldbody>" + tendons + "</mujoco>";
    }

    mujoco_files file;

  private:
    static constexpr double least = 1e-14; /* MuJoCo refuses 1e-15 */

    void site(int body, const vector3 &at, const std::string &name)
    {
        mujoco_files one;
        one.text.push_back("<site name=\"" + name + "\"");
        one.attribute(0, "pos", at);
        sites[(size_t)body] += one.text[0] + "/>";
    }

    /* The three springs of each ball joint are tendons between points. */
    void place_sites()
    {
        tendons = "<tendon>";
        for (int k = 0; k < s.balls; ++k) {
            const stiff_ball &b = s.ball[k];
            const std::string name = std::to_string(k);
            site(b.b, vector(b.at_b), "b" + name);
            for (size_t i = 0; i < 3; ++i) {
                vector3 at = vector(b.at_a);
                at[i] -= b.length;
                const std::string end = "a" + name + "_" + std::to_string(i);
                site(b.a, at, end);
                mujoco_files one;
                one.text.push_back("<spatial");
                one.attribute(0, "stiffness", std::array<double, 1>{b.stiffness});
                one.attribute(0, "damping", std::array<double, 1>{b.damping});
                one.attribute(0, "springlength", std::array<double, 1>{b.length});
                tendons += one.text[0] + "><site site=\"" + end + "\"/><site site=\"b" + name +
                           "\"/></spatial>";
            }
        }
        tendons += "</tendon>";
    }

    void inertia(size_t to, const stiff_body &b)
    {
        vector3 moments = vector(b.tensor);
        for (double &x : moments) x = std::max(x, std::max(share * s.moment_size, least));
        file.text[to] += "<inertial";
        file.attribute(to, "pos", vector(b.com));
        file.attribute(
            to, "mass",
            std::array<double, 1>{b.mass > 0.0 ? b.mass : std::max(share * s.mass_size, least)});
        if (b.tensor[3] == 0.0 && b.tensor[4] == 0.0 && b.tensor[5] == 0.0) {
            file.attribute(to, "diaginertia", moments);
        } else {
            std::array<double, 6> tensor;
            std::copy(b.tensor, b.tensor + 6, tensor.begin());
            file.attribute(to, "fullinertia", tensor);
        }
        file.text[to] += "/>";
    }

    void joints(size_t to, const stiff_body &b)
    {
        if (b.free) file.text[to] += "<freejoint/>";
        for (int i = 0; i < b.axes; ++i) {
            const stiff_axis &a = b.axis[i];
            file.text[to] += a.turns ? "<joint type=\"hinge\"" : "<joint type=\"slide\"";
            file.attribute(to, "axis", vector(a.direction));
            file.attribute(to, "stiffness", std::array<double, 1>{a.stiffness});
            file.attribute(to, "damping", std::array<double, 1>{a.damping});
            file.attribute(to, "springref", std::array<double, 1>{a.rest});
            file.text[to] += "/>";
        }
    }

    void inside(int parent, size_t to, int level)
    {
        const bool deep = level == mujoco_files::LEVELS;
        if (deep) {
            to = file.include(to);
            level = 0;
        }
        for (int k : successors[(size_t)(parent + 1)]) {
            const stiff_body &b = s.body[k];
            file.text[to] += "<body name=\"" + std::to_string(k) + "\"";
            file.attribute(to, "pos", vector(b.place));
            file.text[to] += ">";
            inertia(to, b);
            joints(to, b);
            file.text[to] += sites[(size_t)k];
            inside(k, to, level + 1);
            file.text[to] += "</body>";
        }
        if (deep) file.text[to] += "</mujoco>";
    }

    const stiff_model &s;
    double share;
    std::vector<std::vector<int>> successors;
    std::vector<std::string> sites;
    std::string tendons;
};

/* ---- a run ------------------------------------------------------------------------------------
 * */

bool refused; /* MuJoCo warned: it found numbers too large, and starts anew then */

void warn(const char *)
{
    refused = true;
}

void raise(const char *message)
{
    throw std::runtime_error(message);
}

class simulation
{
  public:
    simulation(const stiff_model &s, const char *integrator, double step, double share)
        : s(s), m(writer(s, integrator, step, share).file.load()), d(mj_makeData(m)),
          places(3 * (size_t)s.bodies)
    {
        for (int k = 0; k < s.bodies; ++k) {
            number.push_back(mj_name2id(m, mjOBJ_BODY, std::to_string(k).c_str()));
            for (int i = 0; i < s.body[k].axes; ++i)
                d->qpos[m->jnt_qposadr[m->body_jntadr[number.back()] + i]] =
                    s.body[k].axis[i].start;
        }
    }

    ~simulation()
    {
        mj_deleteData(d);
        mj_deleteModel(m);
    }

    simulation(const simulation &) = delete;

    void step()
    {
        mj_step1(m, d);
        push();
        mj_step2(m, d);
    }

    bool good() const
    {
        return !refused &&
               std::all_of(d->qvel, d->qvel + m->nv, [](double x) { return std::isfinite(x); });
    }

    const std::vector<double> &where()
    {
        mj_kinematics(m, d);
        for (int k = 0; k < s.bodies; ++k)
            std::copy_n(d->xpos + 3 * number[(size_t)k], 3, places.begin() + 3 * k);
        return places;
    }

  private:
    void push()
    {
        mju_zero(d->qfrc_applied, m->nv);
        for (int k = 0; k < s.loads; ++k) {
            const int body = number[(size_t)s.load[k]];
            double p[3], v[6], r[3], f[3], none[3] = {0.0, 0.0, 0.0};
            mju_rotVecMat(r, s.load_at, d->xmat + 9 * body);
            mju_add3(p, d->xpos + 3 * body, r);
            mj_objectVelocity(m, d, mjOBJ_XBODY, body, v, 0);
            double at[3];
            mju_cross(at, v, r);
            mju_addTo3(at, v + 3);
            s.force(k, d->time, p, at, f);
            mj_applyFT(m, d, f, none, p, body, d->qfrc_applied);
        }
    }

    const stiff_model &s;
    mjModel *m;
    mjData *d;
    std::vector<int> number;
    std::vector<double> places;
};

struct result {
    const char *name;
    long steps;
    double setup, time, error; /* s, m */
};

bool unstable(const result &r)
{
    return std::string(r.name) == "unstable";
}

double largest_distance(const std::vector<double> &a, const std::vector<double> &b)
{
    double most = 0.0;
    for (size_t k = 0; k < a.size(); k += 3) {
        const double one = std::hypot(a[k] - b[k], a[k + 1] - b[k + 1], a[k + 2] - b[k + 2]);
        if (!(one <= most)) most = one;
    }
    return most;
}

result integrate(const stiff_model &s, const char *integrator, double step, double share,
                 const std::vector<double> &reference, double limit)
{
    const long steps = std::lround(s.T / step);
    result r = {"ok", steps, 0.0, 0.0, 0.0};
    refused = false;
    double begin = bench_now();
    simulation one(s, integrator, step, share);
    r.setup = bench_now() - begin;
    begin = bench_now();
    for (long k = 0; k < steps; ++k) {
        one.step();
        if (!one.good()) {
            r.name = "unstable";
            break;
        }
        r.time = bench_now() - begin;
        const double whole = r.time / (double)(k + 1) * (double)steps;
        if (k >= 3 && r.time > 0.2 && whole > limit) {
            r.name = "left_out";
            r.time = whole;
            return r;
        }
    }
    r.time = bench_now() - begin;
    r.error = largest_distance(one.where(), reference);
    return r;
}

/* ---- table ------------------------------------------------------------------------------------
 * */

void report(const stiff_model &s, const char *integrator, double step, double share,
            const result &r)
{
    const double each = 1e6 * r.time / (double)r.steps;
    printf("%s,%d,%d,,mujoco_%s,%g,%s,%ld,,,,,,,,%g,,%.3f,%.3f,%.1f,%.3f,", s.name, s.bodies,
           s.massless, integrator, step, r.name, r.steps, share, r.setup, r.time, each,
           each / s.bodies);
    if (std::string(r.name) == "ok")
        printf("%.2e\n", r.error);
    else
        printf("\n");
    fflush(stdout);
}

struct reference {
    double error; /* m, to reach */
    std::vector<double> places;
};

void run(const stiff_model &s, const char *integrator, const reference &at, double limit)
{
    for (double step = 16e-3; step > 1e-6; step *= 0.5) {
        double share = 1e-12;
        result r = integrate(s, integrator, step, share, at.places, limit);
        while (unstable(r) && share < 1e-3) {
            share *= 1e3;
            r = integrate(s, integrator, step, share, at.places, limit);
        }
        if (unstable(r) && step > 2e-6) continue;
        report(s, integrator, step, share, r);
        if (std::string(r.name) == "left_out" || r.error <= at.error) return;
    }
}

void run_both(stiff_model s, const std::string &folder, double limit)
{
    std::ifstream file(folder + "/" + s.name + "_" + std::to_string(s.bodies) + ".txt");
    reference at;
    at.places.resize(3 * (size_t)s.bodies);
    file >> at.error;
    for (double &x : at.places) file >> x;
    if (file) {
        run(s, "implicit", at, limit);
        run(s, "Euler", at, limit);
    } else {
        printf("# %s %d: no reference\n", s.name, s.bodies);
    }
    stiff_free(&s);
}

stiff_model make(void (*build)(stiff_model *, int), int n)
{
    stiff_model s;
    build(&s, n);
    return s;
}

} // namespace

int main(int argc, char **argv)
{
    const double limit = argc > 2 ? atof(argv[2]) : 30.0;
    if (argc < 2 || !(limit > 0.0)) {
        fprintf(stderr, "runs_mujoco folder [seconds]\n");
        return 2;
    }
    mju_user_error = raise;
    mju_user_warning = warn;
    printf("# MuJoCo %s; tolerance: its step, s; rank: what stands for no mass, "
           "in usual masses; left_out: cpu_s from the first steps\n",
           mj_versionString());
    try {
        run_both(make(stiff_beam, 40), argv[1], limit);
        run_both(make(stiff_beam, 400), argv[1], limit);
        run_both(make(stiff_cable, 40), argv[1], limit);
        run_both(make([](stiff_model *s, int) { stiff_vehicle(s); }, 0), argv[1], limit);
        for (int n : {100, 400, 1000}) run_both(make(stiff_tree, n), argv[1], limit);
    } catch (const std::exception &error) {
        fprintf(stderr, "MuJoCo: %s\n", error.what());
        return 1;
    }
    return 0;
}
