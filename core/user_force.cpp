#include "core/user_force.hpp"

namespace gudgeon {

namespace {

using Element = UserForceKernel::Element;

Vec3 part_of(const PairWrench& w, int part) {
    return part == 0 ? w.force_a : part == 1 ? w.moment_a : part == 2 ? w.force_b : w.moment_b;
}

PairWrench call(double t, const BodyMotion& a, const BodyMotion& b, const Element& x) {
    UserForceOutput out;
    (*x.law)({t, a, b, false}, out);
    return out.wrench;
}

void move(BodyMotion& m, bool rotation_part, int axis, double h) {
    if (!rotation_part) {
        m.r[axis] += h;
        return;
    }
    m.p = turned(m.p, h * Vec3::Unit(axis));
    m.A = rotation(m.p);
}

void push(BodyMotion& m, bool rotation_part, int axis, double h) { (rotation_part ? m.w : m.v)[axis] += h; }

// Column `axis` of block column `part`: -(wrench(+h) - wrench(-h)) / 2h for one way of changing a body.
template <class Change>
void difference(const Evaluation& e, const Element& x, int part, int axis, Change change, BlockMatrix& out) {
    PairWrench w[2];
    for (int side = 0; side < 2; ++side) {
        BodyMotion a = e.body[x.a], b = e.body[x.b];
        change(part < 2 ? a : b, part % 2 == 1, axis, side == 0 ? x.step : -x.step);
        w[side] = call(e.t, a, b, x);
    }
    for (int row = 0; row < 4; ++row)
        out.block[row][part].col(axis) -= (part_of(w[0], row) - part_of(w[1], row)) / (2 * x.step);
}

} // namespace

PairWrench UserForceKernel::wrench(const Evaluation& e, const Element& x) {
    return call(e.t, e.body[x.a], e.body[x.b], x);
}

void UserForceKernel::linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s) {
    BlockMatrix user_c, user_s;
    user_c.set_zero();
    user_s.set_zero();
    UserForceOutput out;
    out.C = &user_c;
    out.S = &user_s;
    (*x.law)({e.t, e.body[x.a], e.body[x.b], true}, out);
    if (out.has_derivatives) {
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                c.block[i][j] += user_c.block[i][j];
                s.block[i][j] += user_s.block[i][j];
            }
        return;
    }
    for (int part = 0; part < 4; ++part) {
        if ((part < 2 ? x.a : x.b) >= e.moving)
            continue;
        for (int axis = 0; axis < 3; ++axis) {
            difference(e, x, part, axis, push, c);
            difference(e, x, part, axis, move, s);
        }
    }
}

EnergyRates UserForceKernel::energies(const Evaluation& e, const Element& x) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    UserForceOutput out;
    (*x.law)({e.t, a, b, false}, out);
    if (out.energies)
        return *out.energies;
    const PairWrench& w = out.wrench;
    return {0, 0, w.force_a.dot(a.v) + w.moment_a.dot(a.w) + w.force_b.dot(b.v) + w.moment_b.dot(b.w)};
}

ForceBatchBuilder user_force_builder(std::vector<UserForce> forces) {
    return [forces = std::move(forces)](const CompileContext& context) -> std::unique_ptr<ForceBatch> {
        if (forces.empty())
            return nullptr;
        auto batch = std::make_unique<ForceBatchOf<UserForceKernel>>();
        for (const UserForce& force : forces) {
            int body[2];
            for (int k = 0; k < 2; ++k) {
                const std::string& name = force.bodies[k];
                body[k] = context.system.body_index(name);
                if (body[k] < 0)
                    throw ModelError(context.model.source, "",
                                     "user force '" + force.name + "': no body '" + name + "'",
                                     "a body of the model or ground");
            }
            if (!force.law)
                throw ModelError(context.model.source, "", "user force '" + force.name + "' has no law",
                                 "a callable");
            Element x;
            x.a = body[0];
            x.b = body[1];
            x.law = std::make_shared<const UserForceLaw>(force.law);
            x.step = force.step;
            batch->add(std::move(x), force.name);
        }
        return batch;
    };
}

} // namespace gudgeon
