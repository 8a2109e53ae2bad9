#include "core/assembly.hpp"

#include "core/parallel.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

constexpr int parallel_bodies = 256;

template <class F> void for_bodies(const System& system, int threads, F&& f) {
    parallel_for(threads, 0, system.moving, parallel_bodies,
                 [&](std::ptrdiff_t i) { f(static_cast<int>(i)); });
}

// Load from outside, turned into the body frame.
Vec3 external_moment(const Workspace& ws, int i) {
    return ws.motion[i].A.transpose() * ws.external.segment<3>(6 * i + 3);
}

} // namespace

State initial_state(const System& system) {
    State s;
    s.q.resize(system.positions());
    s.u.resize(system.velocities());
    s.lambda = VecX::Zero(system.row_count());
    for (int i = 0; i < system.moving; ++i) {
        const BodyMotion& m = system.start[i];
        s.q.segment<3>(7 * i) = m.r;
        s.q.segment<4>(7 * i + 3) = m.p;
        s.u.segment<3>(6 * i) = m.v;
        s.u.segment<3>(6 * i + 3) = m.w;
    }
    const auto angles = static_cast<Eigen::Index>(system.angles.size());
    s.angles.value.resize(angles);
    s.angles.rate = VecX::Zero(angles);
    for (Eigen::Index i = 0; i < angles; ++i)
        s.angles.value[i] = system.angles[i].start;
    const Eigen::Index channels = system.channels();
    s.contacts = {VecX::Constant(channels, -1.0), VecX::Zero(channels), VecX::Zero(channels)};
    s.history.assign(system.contact_joints.size(), {});
    s.z = VecX::Zero(system.friction_states());
    s.work = VecX::Zero(work_count(system));
    return s;
}

Eigen::Index work_count(const System& system) {
    return 2 + static_cast<Eigen::Index>(system.contact_joints.size());
}

Workspace make_workspace(const System& system, int threads) {
    Workspace ws;
    ws.motion = system.start;
    ws.f = VecX::Zero(system.velocities());
    ws.external = VecX::Zero(system.velocities());
    ws.phi = VecX::Zero(system.row_count());
    ws.rate = VecX::Zero(system.row_count());
    ws.rows.assign(12 * system.rows.size(), 0.0);
    ws.lin.pairs = system.layout.pairs;
    const State start = initial_state(system);
    ws.angles = start.angles;
    ws.z = start.z;
    ws.lambda = start.lambda;
    ws.contacts = start.contacts;
    ws.scratch.assign(system.scratch, 0.0);
    ws.samples.assign(system.contacts.size(), {});
    ws.apart.assign(system.contacts.size(), 0);
    ws.threads = threads;
    return ws;
}

void set_motion(const System& system, const VecX& q, const VecX& u, Workspace& ws) {
    for_bodies(system, ws.threads, [&](int i) {
        BodyMotion& m = ws.motion[i];
        m.r = q.segment<3>(7 * i);
        m.p = q.segment<4>(7 * i + 3).normalized();
        m.A = rotation(m.p);
        m.v = u.segment<3>(6 * i);
        m.w = u.segment<3>(6 * i + 3);
    });
}

Evaluation evaluation(const System& system, Workspace& ws, double t) {
    return {t,
            ws.motion.data(),
            system.moving,
            ws.angles.value.data(),
            ws.angles.rate.data(),
            ws.angles.t,
            ws.threads,
            ws.contacts.start_speed.data(),
            ws.contacts.place.data(),
            ws.z.data(),
            ws.lambda.data(),
            ws.scratch.data(),
            system.mass.data(),
            system.inverse_inertia.data(),
            ws.frozen,
            ws.apart.data()};
}

void evaluate_forces(const System& system, double t, Workspace& ws) {
    for_bodies(system, ws.threads, [&](int i) {
        const Vec3& w = ws.motion[i].w;
        const Vec3 gyroscopic = w.cross(system.inertia[i] * w);
        ws.f.segment<3>(6 * i) = ws.external.segment<3>(6 * i) + system.mass[i] * system.gravity;
        ws.f.segment<3>(6 * i + 3) = external_moment(ws, i) - gyroscopic;
    });
    const Evaluation e = evaluation(system, ws, t);
    for (const auto& batch : system.forces)
        batch->add_forces(e, {ws.f.data(), system.moving});
}

void evaluate_constraints(const System& system, double t, const double* lambda, bool with_rows,
                          Workspace& ws) {
    const Evaluation e = evaluation(system, ws, t);
    const ConstraintSink sink{ws.phi.data(),
                              ws.rate.data(),
                              with_rows ? ws.rows.data() : nullptr,
                              lambda,
                              {ws.f.data(), system.moving}};
    for (const auto& batch : system.constraints)
        batch->evaluate(e, sink);
}

namespace {
// In chunks, so that threads take their parts.
void clear_blocks(const System& system, int threads, Linearisation& lin) {
    constexpr std::ptrdiff_t chunk = 4096;
    const auto size = static_cast<std::ptrdiff_t>(9 * system.layout.block_row.size());
    const bool both = lin.joined == 0;
    lin.C.resize(size);
    lin.S.resize(both ? size : 0);
    parallel_for(threads, 0, (size + chunk - 1) / chunk, 4, [&](std::ptrdiff_t i) {
        const std::ptrdiff_t end = std::min((i + 1) * chunk, size);
        std::fill(lin.C.begin() + i * chunk, lin.C.begin() + end, 0.0);
        if (both)
            std::fill(lin.S.begin() + i * chunk, lin.S.begin() + end, 0.0);
    });
}
} // namespace

void linearise(const System& system, double t, const double* lambda, Workspace& ws, double joined) {
    ws.lin.joined = joined;
    clear_blocks(system, ws.threads, ws.lin);
    ws.lin.states.clear();
    ws.lin.reactions.clear();
    Evaluation e = evaluation(system, ws, t);
    e.lambda = lambda;
    for_bodies(system, ws.threads, [&](int i) {
        const Vec3& w = ws.motion[i].w;
        const Mat3& j = system.inertia[i];
        Linearisation::add(ws.lin.C, 4 * i + 3, skew(w) * j - skew(j * w));
        const Mat3 loads = -skew(external_moment(ws, i));
        if (ws.lin.joined == 0)
            Linearisation::add(ws.lin.S, 4 * i + 3, loads);
        else
            Linearisation::add(ws.lin.C, 4 * i + 3, ws.lin.joined * loads);
    });
    for (const auto& batch : system.forces)
        batch->add_linearisation(e, ws.lin);
    ConstraintSink sink;
    sink.rows = ws.rows.data();
    for (const auto& batch : system.constraints) {
        batch->evaluate(e, sink);
        batch->add_geometric(e, lambda, ws.lin);
    }
}

void mass_times(const System& system, const VecX& x, VecX& out) {
    for (int i = 0; i < system.moving; ++i) {
        out.segment<3>(6 * i) = system.mass[i] * x.segment<3>(6 * i);
        out.segment<3>(6 * i + 3) = (system.inertia[i] * x.segment<3>(6 * i + 3)).eval();
    }
}

void inverse_mass_times(const System& system, const VecX& x, VecX& out) {
    for (int i = 0; i < system.moving; ++i) {
        out.segment<3>(6 * i) = x.segment<3>(6 * i) / system.mass[i];
        out.segment<3>(6 * i + 3) = (system.inverse_inertia[i] * x.segment<3>(6 * i + 3)).eval();
    }
}

void add_transposed_rows(const System& system, const Workspace& ws, const VecX& x, double factor, VecX& out) {
    for (int r = 0; r < system.row_count(); ++r) {
        const RowRecord& row = system.rows[r];
        const Eigen::Map<const Eigen::Matrix<double, 12, 1>> g(ws.rows.data() + 12 * std::size_t(r));
        if (row.a < system.moving)
            out.segment<6>(6 * row.a) += factor * x[r] * g.head<6>();
        if (row.b < system.moving)
            out.segment<6>(6 * row.b) += factor * x[r] * g.tail<6>();
    }
}

namespace {
void rows_product(const System& system, const std::vector<double>& rows, const VecX& x, VecX& out) {
    for (int r = 0; r < system.row_count(); ++r) {
        const RowRecord& row = system.rows[r];
        const Eigen::Map<const Eigen::Matrix<double, 12, 1>> g(rows.data() + 12 * std::size_t(r));
        out[r] = 0;
        if (row.a < system.moving)
            out[r] += g.head<6>().dot(x.segment<6>(6 * row.a));
        if (row.b < system.moving)
            out[r] += g.tail<6>().dot(x.segment<6>(6 * row.b));
    }
}
} // namespace

void rows_times(const System& system, const Workspace& ws, const VecX& x, VecX& out) {
    rows_product(system, ws.rows, x, out);
}

void rate_rows_times(const System& system, const Workspace& ws, const VecX& x, VecX& out) {
    rows_product(system, ws.rate_rows, x, out);
}

void evaluate_rate_rows(const System& system, double t, Workspace& ws) {
    ws.rate_rows.resize(12 * system.rows.size());
    const Evaluation e = evaluation(system, ws, t);
    for (const auto& batch : system.constraints)
        batch->rate_gradient(e, ws.rate_rows.data());
}

void blocks_times(const System& system, const std::vector<double>& blocks, const VecX& x, VecX& out) {
    out.setZero();
    const BlockLayout& layout = system.layout;
    for (int id = 0; id < layout.blocks(); ++id)
        if (layout.active[id])
            out.segment<3>(3 * layout.block_row[id]) +=
                Eigen::Map<const Mat3>(blocks.data() + 9 * std::size_t(id)) *
                x.segment<3>(3 * layout.block_col[id]);
}

double cancelling_stiffness(const System& system, const Workspace& ws, const VecX& x) {
    const BlockLayout& layout = system.layout;
    double sum = 0;
    for (int id = 0; id < layout.blocks(); ++id)
        if (layout.active[id])
            sum += x.segment<3>(3 * layout.block_row[id])
                       .cwiseAbs()
                       .dot(Eigen::Map<const Mat3>(ws.lin.S.data() + 9 * std::size_t(id)).cwiseAbs() *
                            x.segment<3>(3 * layout.block_col[id]).cwiseAbs());
    return sum;
}

void move(const System& system, const VecX& step, VecX& q) {
    for (int i = 0; i < system.moving; ++i) {
        q.segment<3>(7 * i) += step.segment<3>(6 * i);
        q.segment<4>(7 * i + 3) = turned(q.segment<4>(7 * i + 3), step.segment<3>(6 * i + 3));
    }
}

void sample_contacts(const System& system, double t, Workspace& ws) {
    if (system.contacts.empty())
        return;
    const Evaluation e = evaluation(system, ws, t);
    for (const auto& batch : system.forces)
        if (batch->has_contacts())
            batch->sample_contacts(e, ws.samples);
}

std::vector<JointContact> joint_contacts(const System& system, const Workspace& ws) {
    const std::size_t n = system.contact_joints.size();
    std::vector<JointContact> out(n);
    std::vector<Vec3> normal(n, Vec3::Zero()), friction(n, Vec3::Zero());
    for (std::size_t c = 0; c < system.contacts.size(); ++c) {
        const ContactSample& sample = ws.samples[c];
        const int joint = system.joints[system.contacts[c].joint].contact;
        normal[joint] += sample.normal_force;
        friction[joint] += sample.friction_force;
        if (!(sample.depth > 0))
            continue;
        JointContact& contact = out[joint];
        contact.penetration = std::max(contact.penetration, sample.depth);
        contact.touching += sample.force > 0;
        if (sample.normal_force.isZero())
            contact.normal_force = std::max(contact.normal_force, sample.force);
        // moments have no force, and faces that turn rub more than their resultant
        if (sample.friction > (1 + 1e-9) * sample.friction_force.norm())
            contact.friction_force = std::max(contact.friction_force, sample.friction);
    }
    for (std::size_t i = 0; i < n; ++i) {
        out[i].normal_force = std::max(out[i].normal_force, normal[i].norm());
        out[i].friction_force = std::max(out[i].friction_force, friction[i].norm());
    }
    return out;
}

void joint_wrenches(const System& system, double t, const VecX& lambda, Workspace& ws,
                    std::vector<Wrench>& out) {
    out.assign(system.joints.size(), Wrench{});
    for (int r = 0; r < system.row_count(); ++r) {
        const Eigen::Map<const Eigen::Matrix<double, 12, 1>> g(ws.rows.data() + 12 * std::size_t(r));
        Wrench& w = out[system.rows[r].joint];
        w.force -= lambda[r] * g.segment<3>(6);
        w.moment -= lambda[r] * g.segment<3>(9);
    }
    const Evaluation e = evaluation(system, ws, t);
    for (const auto& batch : system.forces)
        batch->add_joint_wrenches(e, out);
    for (std::size_t j = 0; j < system.joints.size(); ++j) {
        const Anchor& b = system.joints[j].b;
        const Mat3& A = ws.motion[b.body].A;
        Wrench& w = out[j];
        w.moment = A * w.moment - (A * b.point).cross(w.force);
    }
}

void powers(const System& system, double t, const double* lambda, Workspace& ws, VecX& out, bool sampled) {
    Evaluation e = evaluation(system, ws, t);
    if (lambda)
        e.lambda = lambda;
    out.setZero();
    for (int i = 0; i < system.moving; ++i)
        out[1] +=
            ws.external.segment<3>(6 * i).dot(ws.motion[i].v) + external_moment(ws, i).dot(ws.motion[i].w);
    for (const auto& batch : system.forces) {
        if (batch->has_contacts())
            continue;
        const EnergyRates rates = batch->energies(e);
        out[0] += rates.dissipated_power;
        out[1] += rates.input_power;
    }
    if (lambda)
        for (const auto& batch : system.constraints)
            out[1] += batch->drive_power(e, lambda);
    if (!sampled)
        sample_contacts(system, t, ws);
    ws.for_near(system, [&](std::size_t, int first, int last) {
        const int joint = system.joints[system.contacts[first].joint].contact;
        for (int c = first; c < last; ++c) {
            out[0] += ws.samples[c].dissipated_power;
            out[2 + joint] += ws.samples[c].dissipated_power;
        }
    });
}

void state_terms(const System& system, double t, Workspace& ws, VecX& source, VecX& decay) {
    const Evaluation e = evaluation(system, ws, t);
    for (const auto& batch : system.forces)
        batch->state_terms(e, source.data(), decay.data());
}

Energies energies(const System& system, double t, const double* lambda, Workspace& ws) {
    Energies sum;
    for (int i = 0; i < system.moving; ++i) {
        const BodyMotion& m = ws.motion[i];
        sum.kinetic += 0.5 * (system.mass[i] * m.v.squaredNorm() + m.w.dot(system.inertia[i] * m.w));
        sum.potential -= system.mass[i] * system.gravity.dot(m.r);
        sum.input_power += ws.external.segment<3>(6 * i).dot(m.v) + external_moment(ws, i).dot(m.w);
    }
    Evaluation e = evaluation(system, ws, t);
    if (lambda)
        e.lambda = lambda;
    for (const auto& batch : system.forces) {
        const EnergyRates rates = batch->energies(e);
        sum.elastic += rates.elastic;
        sum.dissipated_power += rates.dissipated_power;
        sum.input_power += rates.input_power;
    }
    if (lambda)
        for (const auto& batch : system.constraints)
            sum.input_power += batch->drive_power(e, lambda);
    return sum;
}

void update_angles(const System& system, double t, const Workspace& ws, AngleMemory& angles) {
    for (std::size_t i = 0; i < system.angles.size(); ++i) {
        const AngleRecord& x = system.angles[i];
        const BodyMotion &a = ws.motion[x.a], &b = ws.motion[x.b];
        const double rate = angle::gradient(a, b, x.frames).times(a, b)[0];
        // the mean rate foresees the turn of a step better than either end
        const double foreseen = angles.value[i] + 0.5 * (t - angles.t) * (angles.rate[i] + rate);
        angles.value[i] = angle::value(a, b, x.frames, foreseen);
        angles.rate[i] = rate;
    }
    angles.t = t;
}

} // namespace gudgeon
