/* From C++17: an object that frees what it holds, failures as exceptions, forces as lambdas.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The wrapper below is all there is to it, to be copied and changed. An exception must not pass
 * through the library, which is C: a function that is called back catches it, returns a status of
 * its own, and it is thrown again where the library has returned. The model is a pendulum whose
 * pivot, without mass, slides on a spring and a damper and is pulled by a lambda; energy and work
 * add up. Another lambda throws. */
#include <mbsrank/simulation.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <list>
#include <stdexcept>
#include <utility>
#include <vector>

namespace
{

class Simulation
{
  public:
    Simulation() : s_(mbsr_simulation_begin(nullptr))
    {
        check();
    }
    ~Simulation()
    {
        mbsr_simulation_end(&s_);
    }
    Simulation(const Simulation &) = delete;
    Simulation &operator=(const Simulation &) = delete;

    int add_body(const char *name, int parent, const mbsr_joint &joint, const mbsr_inertia &inertia)
    {
        const int id = mbsr_simulation_add_body(&s_, name, parent, joint, inertia);
        check();
        return id;
    }
    int add_force(const mbsr_force_def &force)
    {
        const int id = mbsr_simulation_add_force(&s_, force);
        check();
        return id;
    }
    /* A force or torque along the joint coordinate of a body, as a function of time. */
    int add_drive(int body, std::function<double(double)> law)
    {
        laws_.push_back({this, std::move(law)}); /* a list: its elements stay where they are */
        return add_force(mbsr_force_joint_applied(body, call, &laws_.back()));
    }
    void start(double t, const std::vector<double> &q, const std::vector<double> &u)
    {
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        opt.rtol = opt.atol = 1e-9;
        mbsr_simulation_start(&s_, &opt, t, q.data(), u.data());
        check();
    }
    void to(double t)
    {
        mbsr_simulation_to(&s_, t);
        check();
    }
    const mbsr_simulation &now() const
    {
        return s_;
    }

  private:
    struct Law {
        Simulation *owner;
        std::function<double(double)> value;
    };
    static constexpr int thrown = -4711; /* below zero: no shorter step would help */

    static int call(void *user, double t, int, double *value) noexcept
    {
        Law *law = static_cast<Law *>(user);
        try {
            value[0] = law->value(t);
        } catch (...) {
            law->owner->caught_ = std::current_exception();
            return thrown;
        }
        return MBSR_OK;
    }
    void check()
    {
        if (caught_) std::rethrow_exception(std::exchange(caught_, nullptr));
        if (s_.status != MBSR_OK) throw std::runtime_error(s_.error.text);
    }

    mbsr_simulation s_;
    std::list<Law> laws_;
    std::exception_ptr caught_;
};

/* A pendulum of 1 kg and 1 m on a pivot without mass. */
void build(Simulation &s, std::function<double(double)> pull)
{
    const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, tip[3] = {0, 0, -1};
    const int pivot = s.add_body("pivot", MBSR_GROUND, mbsr_joint_prismatic(nullptr, nullptr, x),
                                 mbsr_inertia_zero());
    s.add_body("pendulum", pivot, mbsr_joint_revolute(nullptr, nullptr, y),
               mbsr_inertia_point_mass(1.0, tip));
    s.add_force(mbsr_force_joint_spring(pivot, 0, 200.0, 8.0, 0.0));
    s.add_force(mbsr_force_gravity(0.0, 0.0, -9.81));
    s.add_drive(pivot, std::move(pull));
}

double energy(const mbsr_simulation &s)
{
    double kinetic = 0.0, potential = 0.0;
    if (mbsr_energy(s.model, s.data, &kinetic, &potential))
        throw std::runtime_error(mbsr_data_error(s.data)->text);
    return kinetic + potential;
}

/* What energy and work do not add up by, J; the work by the rule of trapezoids. */
double swing()
{
    const double amplitude = 5.0;
    const auto pull = [amplitude](double t) { return amplitude * std::sin(4.0 * t); };
    Simulation s;
    build(s, pull);
    s.start(0.0, {0.0, 0.6}, {0.0, 0.0});
    const auto power = [&] { return s.now().u[0] * (pull(s.now().t) - 8.0 * s.now().u[0]); };
    const double begin = energy(s.now());
    double work = 0.0, before = power();
    const int samples = 20000;
    for (int k = 1; k <= samples; ++k) {
        s.to(2.0 * k / samples);
        const double after = power();
        work += 0.5 * 2.0 / samples * (before + after);
        before = after;
    }
    std::printf("t = %g s: pivot at %.6f m, pendulum at %.6f rad; energy %+.6f J, work %+.6f J\n",
                s.now().t, s.now().q[0], s.now().q[1], energy(s.now()) - begin, work);
    return std::fabs(energy(s.now()) - begin - work);
}

} // namespace

int main()
{
    int caught = 0;
    double defect = 1.0;
    try {
        defect = swing();
    } catch (const std::exception &failure) {
        std::fprintf(stderr, "%s\n", failure.what());
    }
    try { /* of one's own, through the library */
        Simulation s;
        build(s, [](double t) { return t < 0.5 ? 0.0 : throw std::domain_error("no fuel left"); });
        s.start(0.0, {0.0, 0.6}, {0.0, 0.0});
        s.to(1.0);
    } catch (const std::domain_error &failure) {
        std::printf("caught: %s\n", failure.what());
        ++caught;
    }
    try { /* of the library */
        Simulation s;
        s.add_force(mbsr_force_joint_spring(7, 0, 1.0, 0.0, 0.0));
        s.start(0.0, {}, {});
    } catch (const std::runtime_error &failure) {
        std::printf("caught: %s\n", failure.what());
        ++caught;
    }
    return defect < 1e-5 && caught == 2 ? 0 : 1;
}
